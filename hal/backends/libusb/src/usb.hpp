#pragma once
#include <libusb.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "hal/base/result.hpp"

namespace onemap::hal::libusb {

// A Kinect's camera on the bus.
struct Plugged {
  int bus = 0, address = 0;
  bool for_windows = false;  // 045e:02bf, else the Xbox 360's 045e:02ae
  std::string port;          // where it is plugged in: "1.2" is the second port of what is at the bus's first
  std::string serial;        // empty: it has none, or it cannot be read
  std::string problem;       // why it cannot be used; empty when it can
  std::string model() const { return for_windows ? "Kinect for Windows v1" : "Kinect v1"; }
  bool same_stay(const Plugged& other) const { return bus == other.bus && address == other.address; }
  bool same_socket(const Plugged& other) const { return bus == other.bus && port == other.port; }
};

// As the kernel names it without the bus; empty where it is not known.
std::string port_of(libusb_device* device);

// Why a device of this speed cannot stream: Kinect's pictures need USB 2's high speed. Empty when it can, or when the
// machine does not know the speed.
std::string speed_problem(int libusb_speed);

// A libusb context of our own, which hears Kinects come and go while its events are handled.
class Usb {
 public:
  static Result<std::unique_ptr<Usb>> open();
  ~Usb();
  Usb(const Usb&) = delete;
  Usb& operator=(const Usb&) = delete;

  libusb_context* context() { return context_; }
  // In the bus's order, which is libfreenect's. Opens each for a moment to read its serial number.
  std::vector<Plugged> kinects();

  void watch(int bus, int address);  // forgets what was, and notes when this one leaves
  bool left() const { return left_; }
  bool wait_for_arrival(std::chrono::milliseconds timeout);  // one has come since the last call that answered true

 private:
  Usb() = default;
  static int on_hotplug(libusb_context* context, libusb_device* device, libusb_hotplug_event event, void* self);
  libusb_context* context_ = nullptr;
  libusb_hotplug_callback_handle callback_ = 0;
  bool listens_ = false;
  std::atomic<int> watched_ = -1;  // bus * 256 + address
  std::atomic<bool> left_ = false;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool arrived_ = false;  // with mutex_
};

}  // namespace onemap::hal::libusb
