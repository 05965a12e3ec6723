#pragma once
// A USB bus that umockdev plays: what is plugged in there is a device of tests/cameras, and the real libusb talks to
// it.
#include <memory>
#include <vector>

#include "cameras/usb_device.hpp"

struct _UMockdevTestbed;

namespace onemap::test {

// The kernel's side of one device (usbfs): takes libusb's requests to the device and brings back its answers.
class MockPort;

class MockBus {
 public:
  MockBus();
  ~MockBus();
  MockBus(const MockBus&) = delete;
  MockBus& operator=(const MockBus&) = delete;

  // As the next device of bus 1. The device must live as long as the bus.
  void plug(int socket, UsbDevice& device, UsbPort::Speed speed = UsbPort::Speed::high);
  void unplug(int socket);
  // It no longer answers from the request after so many on, and the kernel does not tell of it before unplug().
  void pull_out_at(int socket, int request);
  // The device has something to send.
  void step(int socket);

 private:
  struct Plugged {
    int socket = 0;
    std::unique_ptr<MockPort> port;
    bool present = true;
  };
  Plugged* at(int socket);

  _UMockdevTestbed* testbed_;
  std::vector<Plugged> plugged_;  // those that were pulled out, too: somebody may still hold them open
};

}  // namespace onemap::test
