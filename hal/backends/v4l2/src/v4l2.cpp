#include "hal/backends/v4l2.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "device.hpp"
#include "models.hpp"
#include "v4l2_camera.hpp"

namespace onemap::hal {

namespace {

using namespace v4l2;

std::string people_call_it(const NodePlace& place) {
  std::string text = place.product.empty() ? place.name : place.product;
  if (!place.serial.empty()) text += " " + place.serial;
  if (!place.usb_id.empty()) text += fmt::format(" (USB {})", place.usb_id);
  return text;
}

std::string abilities_of(const Device& device) {
  const auto one = [](const char* what, const NodePlace& place, FourCc format) {
    const auto node = Node::open(place.path);
    return std::string(what) + " " + place.path + " " + text_of(format) + " " +
           (node ? node->sizes(format) : node.error().reason);
  };
  return one("depth", device.depth, device.depth_format) + "; " + one("colour", device.colour, device.colour_format);
}

// A depth camera needs more than USB 2's 480 Mbit/s for its larger modes; it works, and is slower.
std::string note_on_bus(const NodePlace& place) { return place.speed == "480" ? "; on a USB 2 port (480 Mbit/s)" : ""; }

CameraInfo describe(const NodePlace& depth) {
  CameraInfo info{"v4l2:" + depth.path, people_call_it(depth), "", ""};
  V4l2Address address;
  address.text = info.address;
  address.depth_path = depth.path;
  const auto device = find_device(address);
  if (!device) {
    info.problem = device.error().text();
    return info;
  }
  info.abilities = abilities_of(*device) + note_on_bus(depth);
  std::string source;
  const auto rig = calibration_of(address, *device, source);
  if (rig)
    info.abilities += "; calibration " + source;
  else
    info.problem = rig.error().reason;
  return info;
}

}  // namespace

Status check_v4l2(const CameraAddress& address) {
  const auto parsed = parse_v4l2_address(address);
  return parsed ? success() : Status(parsed.error());
}

Result<std::unique_ptr<DepthCamera>> open_v4l2(const CameraAddress& address) {
  const auto parsed = parse_v4l2_address(address);
  if (!parsed) return parsed.error();
  return V4l2Camera::open(*parsed);
}

std::vector<CameraInfo> list_v4l2() {
  std::vector<CameraInfo> cameras;
  for (const NodePlace& place : find_nodes()) {
    const auto node = Node::open(place.path);
    if (node && depth_format(node->formats(), false) != 0) cameras.push_back(describe(place));
    if (!node && access(place.path.c_str(), R_OK | W_OK) != 0)
      cameras.push_back({"v4l2:" + place.path, people_call_it(place), "", node.error().text()});
  }
  std::stable_partition(cameras.begin(), cameras.end(), [](const CameraInfo& c) { return c.problem.empty(); });
  return cameras;
}

}  // namespace onemap::hal
