// Control and bulk transfers by the real libusb: a picture of the virtual depth camera of USB's video class, whose
// streams the kernel's driver reads in the virtual machine.
#include <gtest/gtest.h>
#include <libusb.h>

#include "cameras/uvc_device.hpp"
#include "virtual_kinect.hpp"

namespace onemap::test {
namespace {

constexpr unsigned kMost_ms = 20000;

class OpenDevice {
 public:
  OpenDevice(std::uint16_t vendor, std::uint16_t product) {
    libusb_init(&context_);
    handle_ = libusb_open_device_with_vid_pid(context_, vendor, product);
  }
  ~OpenDevice() {
    if (handle_) libusb_close(handle_);
    libusb_exit(context_);
  }
  libusb_device_handle* handle() const { return handle_; }

 private:
  libusb_context* context_ = nullptr;
  libusb_device_handle* handle_ = nullptr;
};

// The video class's payloads: a header whose first byte is its length, whose second says when an image ends.
Bytes image_from(libusb_device_handle* handle, unsigned char endpoint) {
  Bytes image, payload(1 << 14);
  for (bool last = false; !last;) {
    int bytes = 0;
    if (libusb_bulk_transfer(handle, endpoint, payload.data(), static_cast<int>(payload.size()), &bytes, kMost_ms) != 0)
      return {};
    if (bytes < 2) return {};
    last = (payload[1] & 2) != 0;
    image.insert(image.end(), payload.begin() + payload[0], payload.begin() + bytes);
  }
  return image;
}

TEST(UsbBus, ControlAndBulkTransfersBringAPictureAndAStallIsAnError) {
  const Film film = Film::shoot("simulated:office?width=160&height=120&frames=2", UvcDevice::develop);
  Shutter shutter(film.pictures().size());
  UvcDevice device(film, shutter);
  MockBus bus;
  bus.plug(1, device);
  const OpenDevice usb(0x8086, 0x0b07);
  ASSERT_NE(usb.handle(), nullptr);
  Bytes mode(34);
  constexpr std::uint8_t kSet = 1, kGet = 0x81, kOut = 0x21, kIn = 0xa1;
  constexpr std::uint16_t kProbe = 0x0100, kCommit = 0x0200;
  const auto size = static_cast<std::uint16_t>(mode.size());
  EXPECT_GT(libusb_control_transfer(usb.handle(), kIn, kGet, kProbe, 1, mode.data(), size, kMost_ms), 0);
  EXPECT_EQ(mode[18] | mode[19] << 8, 160 * 120 * 2) << "bytes of an image";
  EXPECT_EQ(libusb_control_transfer(usb.handle(), kIn, kGet, 0x7700, 1, mode.data(), size, kMost_ms),
            LIBUSB_ERROR_PIPE);
  for (const std::uint16_t interface : {1, 3}) {
    ASSERT_EQ(libusb_claim_interface(usb.handle(), interface), 0);
    EXPECT_EQ(libusb_control_transfer(usb.handle(), kOut, kSet, kCommit, interface, mode.data(), size, kMost_ms), size);
  }
  for (const Film::Picture& picture : film.pictures()) {
    shutter.press();
    EXPECT_EQ(image_from(usb.handle(), 0x81), picture.depth);
    EXPECT_EQ(image_from(usb.handle(), 0x82), picture.colour);
  }
  bus.unplug(1);
  EXPECT_EQ(image_from(usb.handle(), 0x81), Bytes());
}

}  // namespace
}  // namespace onemap::test
