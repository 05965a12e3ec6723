#include "hal/backends/openni2.hpp"

#include <fmt/format.h>

#include "address.hpp"
#include "hal/backends/openni2/usb_place.hpp"
#include "hal/base/text.hpp"
#include "library.hpp"
#include "openni2_camera.hpp"

namespace onemap::hal {

Status check_openni2(const CameraAddress& address) {
  const auto parsed = openni2::parse_address(address);
  return parsed ? success() : Status(parsed.error());
}

Result<std::unique_ptr<DepthCamera>> open_openni2(const CameraAddress& address) {
  auto parsed = openni2::parse_address(address);
  if (!parsed) return parsed.error();
  return openni2::OpenNi2Camera::open(std::move(*parsed));
}

std::vector<CameraInfo> list_openni2() {
  std::vector<CameraInfo> all;
  const auto library = openni2::Library::load();
  if (!library) return {{"openni2:", "OpenNI2", "", library.error().reason}};
  for (const openni::DeviceInfo& info : openni2::connected_devices()) {
    const openni2::Identity identity = openni2::identity_of(info);
    all.push_back({printable("openni2:" + identity.uri),
                   printable(fmt::format("{} (USB {:04x}:{:04x})", identity.name, identity.vendor, identity.product)),
                   "depth and colour, 640x480 at 30 Hz where it can", openni2::usb_problem(identity.uri)});
  }
  return all;
}

}  // namespace onemap::hal
