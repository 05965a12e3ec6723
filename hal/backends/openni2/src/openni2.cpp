#include "hal/backends/openni2.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>

#include "address.hpp"
#include "hal/base/text.hpp"
#include "library.hpp"
#include "openni2_camera.hpp"

namespace onemap::hal {

namespace {

// The drivers of USB devices name them VENDOR/PRODUCT@BUS/DEVICE. Whether we may open such a one, without opening it.
std::string problem_of(std::string_view uri) {
  const std::size_t at = uri.rfind('@'), slash = uri.rfind('/');
  if (at == std::string_view::npos || slash == std::string_view::npos || slash < at) return {};
  int bus = 0, device = 0;
  std::from_chars(uri.data() + at + 1, uri.data() + slash, bus);
  std::from_chars(uri.data() + slash + 1, uri.data() + uri.size(), device);
  const std::string node = fmt::format("/dev/bus/usb/{:03}/{:03}", bus, device);
  if (access(node.c_str(), R_OK | W_OK) == 0) return {};
  return node + ": " + std::strerror(errno);
}

}  // namespace

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
                   "depth and colour, 640x480 at 30 Hz where it can", problem_of(identity.uri)});
  }
  return all;
}

}  // namespace onemap::hal
