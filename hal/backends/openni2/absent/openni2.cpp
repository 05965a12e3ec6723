// In place of the backend where the OpenNI2 library was not there when onemap was built.
#include "hal/backends/openni2.hpp"

namespace onemap::hal {

Status check_openni2(const CameraAddress& address) {
  return Error{"camera address '" + address.text + "'",
               "this build has no OpenNI2 (libopenni2-dev was not there when it was configured)"};
}

Result<std::unique_ptr<DepthCamera>> open_openni2(const CameraAddress& address) {
  return check_openni2(address).error();
}

std::vector<CameraInfo> list_openni2() { return {}; }

}  // namespace onemap::hal
