#pragma once
#include <linux/usbdevice_fs.h>
#include <umockdev.h>

#include <atomic>
#include <deque>
#include <map>
#include <mutex>
#include <string>

#include "cameras/usb_device.hpp"

namespace onemap::test {

// usbfs (drivers/usb/core/devio.c) for one device. libusb runs in this very process, so its memory is written to
// directly, as the kernel does.
class MockPort final : public UsbPort {
 public:
  // node: the device's file. umockdev's own is always ready to be written to; ours is a pipe that is so only while
  // there is something to reap, which is what libusb waits for.
  MockPort(UsbDevice& device, Speed speed, const std::string& node);
  ~MockPort() override;
  void attach(UMockdevTestbed* testbed, const std::string& path);
  void detach();

  void step();
  void pull_out();
  void pull_out_at(int request) { until_pulled_out_ = request; }  // as the request after so many comes

  void plug() override {}
  void answer(const Urb& urb, std::span<const std::uint8_t> data) override;
  void answer_packets(const Urb& urb, std::span<const std::vector<std::uint8_t>> packets) override;
  void refuse(const Urb& urb) override;
  void give_back(const Request& request, bool was_waiting) override;

  static gboolean on_ioctl(UMockdevIoctlBase* base, UMockdevIoctlClient* client);

 private:
  using File = UMockdevIoctlClient*;  // somebody has the device open: each reaps what is his
  struct Owned {
    File file;
    usbdevfs_urb* urb;
  };
  int call(File file, unsigned long request, void* argument);  // 0, or errno
  int submit(const Owned& owned);
  int discard(const usbdevfs_urb* urb);
  void vanish();
  int reap(File file, void** into);
  void complete(std::uint32_t number, int status, int bytes);
  void show_ready();

  UsbDevice& device_;
  int pipe_ = -1;
  UMockdevTestbed* testbed_ = nullptr;
  UMockdevIoctlBase* handler_ = nullptr;
  std::string path_;
  std::mutex mutex_;
  std::uint32_t last_number_ = 0;
  std::map<std::uint32_t, Owned> submitted_;
  std::deque<Owned> done_;
  bool present_ = true, ready_ = true;
  std::atomic<int> until_pulled_out_ = -1;  // requests; negative: it stays
};

}  // namespace onemap::test
