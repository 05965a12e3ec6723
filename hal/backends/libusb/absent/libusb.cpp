// In place of the backend where libfreenect was not there when onemap was built.
#include "hal/backends/libusb.hpp"

#include "hal/backends/libusb/usb_watch.hpp"

namespace onemap::hal {

Status check_libusb(const CameraAddress& address) {
  return Error{"camera address '" + address.text + "'",
               "this build has no libfreenect (libfreenect-dev was not there when it was configured)"};
}

Result<std::unique_ptr<DepthCamera>> open_libusb(const CameraAddress& address) { return check_libusb(address).error(); }

std::vector<CameraInfo> list_libusb() { return {}; }

struct UsbWatch::Parts {};
UsbWatch::UsbWatch(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
UsbWatch::~UsbWatch() = default;
Result<std::unique_ptr<UsbWatch>> UsbWatch::start() {
  return Error{"USB", "nothing is heard of cameras that come and go: this build has no libusb"};
}
std::vector<UsbNews> UsbWatch::news(Instant) { return {}; }

}  // namespace onemap::hal
