#pragma once
// A USB bus that umockdev plays, with devices that have descriptors and nothing else: what is listed, and heard of.
#include <gtest/gtest.h>
#include <umockdev.h>

#include <array>
#include <string>

namespace onemap::test {

// A Kinect's camera as its descriptors say it: device, configuration, interface, two isochronous endpoints. It has no
// serial number, as some have none.
using Descriptors = std::array<unsigned char, 50>;
inline constexpr Descriptors kKinectDescriptors{
    18, 1, 0x00, 0x02, 0,    0,    0,    64,   0x5e, 0x04, 0xae, 0x02, 0x0b, 0x01, 1, 2, 0, 1,  //
    9,  2, 32,   0,    1,    1,    0,    0xc0, 250,                                             //
    9,  4, 0,    0,    2,    0xff, 0xff, 0xff, 0,                                               //
    7,  5, 0x81, 1,    0x80, 0x0b, 1,    7,    5,    0x82, 1,    0x80, 0x0b, 1};

// version: the device's own, in binary-coded decimals; 0x0320 is USB 3.2.
inline Descriptors device_of(int vendor, int product, int version) {
  auto out = kKinectDescriptors;
  const auto put = [&](std::size_t at, int value) {
    out[at] = static_cast<unsigned char>(value & 255);
    out[at + 1] = static_cast<unsigned char>(value >> 8);
  };
  put(2, version);
  put(8, vendor);
  put(10, product);
  return out;
}

class PlainBus {
 public:
  PlainBus() : testbed_(umockdev_testbed_new()) {}
  explicit PlainBus(UMockdevTestbed* shared) : testbed_(static_cast<UMockdevTestbed*>(g_object_ref(shared))) {}
  ~PlainBus() { g_object_unref(testbed_); }
  PlainBus(const PlainBus&) = delete;
  PlainBus& operator=(const PlainBus&) = delete;

  void plug(int port, const std::string& speed, unsigned char product = 0xae) {
    auto descriptors = kKinectDescriptors;
    descriptors[10] = product;
    plug(port, speed, descriptors);
  }
  void plug(int port, const std::string& speed, const Descriptors& descriptors) {
    std::string hex;
    for (const unsigned char byte : descriptors) {
      constexpr const char* kDigits = "0123456789ABCDEF";
      hex += {kDigits[byte >> 4], kDigits[byte & 15]};
    }
    std::string number = std::to_string(port + 1);
    number.insert(0, 3 - number.size(), '0');
    const std::string device = "P: " + path(port).substr(4) + "\nN: bus/usb/001/" + number +
                               "\nE: DEVNAME=/dev/bus/usb/001/" + number +
                               "\nE: DEVTYPE=usb_device\nE: SUBSYSTEM=usb\nE: BUSNUM=001\nE: DEVNUM=" + number +
                               "\nA: busnum=1\\n\nA: devnum=" + std::to_string(port + 1) + "\\n\nA: speed=" + speed +
                               "\\n\nA: bConfigurationValue=1\\n\nH: descriptors=" + hex + "\n";
    GError* error = nullptr;
    EXPECT_TRUE(umockdev_testbed_add_from_string(testbed_, device.c_str(), &error)) << (error ? error->message : "");
    umockdev_testbed_uevent(testbed_, path(port).c_str(), "add");
  }
  void unplug(int port) {
    umockdev_testbed_uevent(testbed_, path(port).c_str(), "remove");
    umockdev_testbed_remove_device(testbed_, path(port).c_str());
  }

 private:
  static std::string path(int port) { return "/sys/devices/usb1/1-" + std::to_string(port); }
  UMockdevTestbed* testbed_;
};

}  // namespace onemap::test
