// In place of the backend where libfreenect was not there when onemap was built.
#include "hal/backends/libusb.hpp"

namespace onemap::hal {

Status check_libusb(const CameraAddress& address) {
  return Error{"camera address '" + address.text + "'",
               "this build has no libfreenect (libfreenect-dev was not there when it was configured)"};
}

Result<std::unique_ptr<DepthCamera>> open_libusb(const CameraAddress& address) { return check_libusb(address).error(); }

std::vector<CameraInfo> list_libusb() { return {}; }

}  // namespace onemap::hal
