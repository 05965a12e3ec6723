#include "hal/backends/libusb.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "address.hpp"
#include "hal/base/text.hpp"
#include "libusb_camera.hpp"
#include "usb.hpp"

namespace onemap::hal {

Status check_libusb(const CameraAddress& address) {
  const auto parsed = libusb::parse_address(address);
  return parsed ? success() : Status(parsed.error());
}

Result<std::unique_ptr<DepthCamera>> open_libusb(const CameraAddress& address) {
  auto parsed = libusb::parse_address(address);
  if (!parsed) return parsed.error();
  return libusb::LibusbCamera::open(std::move(*parsed));
}

namespace {
// A device chooses its own number, and what follows a '?' are options.
bool can_be_named(const std::string& serial) { return serial.find('?') == serial.npos && printable(serial) == serial; }
}  // namespace

std::vector<CameraInfo> list_libusb() {
  std::vector<CameraInfo> all;
  const auto usb = libusb::Usb::open();
  if (!usb) return {{"libusb:", "USB", "", usb.error().reason}};
  for (const libusb::Plugged& kinect : (*usb)->kinects())
    all.push_back({"libusb:" + (can_be_named(kinect.serial) ? kinect.serial : ""),
                   fmt::format("{}, USB bus {} device {}", kinect.model(), kinect.bus, kinect.address),
                   "640x480 at 30 Hz, depth registered to colour", kinect.problem});
  std::stable_partition(all.begin(), all.end(), [](const CameraInfo& camera) { return camera.problem.empty(); });
  return all;
}

}  // namespace onemap::hal
