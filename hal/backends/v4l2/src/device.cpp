#include "device.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <memory>
#include <optional>

#include "hal/base/file.hpp"
#include "models.hpp"

namespace onemap::hal::v4l2 {

namespace {

// A path that the user named may be a link (/dev/v4l/by-id/...): the node that it leads to, as far as sysfs knows it.
NodePlace place_of(const std::string& path) {
  const std::unique_ptr<char, decltype(&std::free)> real(realpath(path.c_str(), nullptr), &std::free);
  const std::string target = real ? real.get() : path;
  for (NodePlace& node : find_nodes())
    if (node.path == path || node.path == target) return std::move(node);
  NodePlace unknown;
  unknown.path = path;
  return unknown;
}

Result<NodePlace> find_depth(const V4l2Address& address) {
  if (!address.depth_path.empty()) return place_of(address.depth_path);
  const std::vector<NodePlace> nodes = find_nodes();
  std::string seen;
  for (const NodePlace& place : nodes) {
    const auto node = Node::open(place.path);
    if (node && depth_format(node->formats(), false) != 0) return place;
    seen += node ? fmt::format("; {} ({}): no depth format", place.path, node->card())
                 : fmt::format("; {}", node.error().text());
  }
  return Error{"camera address '" + address.text + "'",
               fmt::format("no depth camera among the {} video nodes{}", nodes.size(), seen)};
}

std::optional<NodePlace> find_colour(const NodePlace& depth) {
  std::optional<NodePlace> best;
  int best_rank = colour_rank(0);
  for (const NodePlace& place : find_nodes()) {
    if (place.path == depth.path || place.device != depth.device || depth.device.empty()) continue;
    const auto node = Node::open(place.path);
    if (!node || depth_format(node->formats(), false) != 0) continue;
    const int rank = colour_rank(colour_format(node->formats()));
    if (rank >= best_rank) continue;
    best = place;
    best_rank = rank;
  }
  return best;
}

Result<FourCc> format_of(const NodePlace& place, bool depth, bool named) {
  const auto node = Node::open(place.path);
  if (!node) return node.error();
  const std::vector<FourCc> offered = node->formats();
  const FourCc format = depth ? depth_format(offered, named) : colour_format(offered);
  if (format != 0) return format;
  std::string has;
  for (const FourCc one : offered) has += fmt::format(" {}", text_of(one));
  return Error{place.path,
               std::string(depth ? "no depth format (Z16, Y16)" : "no colour format (YUYV, UYVY, MJPG, GREY)") +
                   "; it has" + (has.empty() ? " none" : has)};
}

}  // namespace

Result<Device> find_device(const V4l2Address& address) {
  const auto depth = find_depth(address);
  if (!depth) return depth.error();
  Device device;
  device.depth = *depth;
  const auto depth_format = format_of(device.depth, true, !address.depth_path.empty());
  if (!depth_format) return depth_format.error();
  if (!address.colour_path.empty()) {
    device.colour = place_of(address.colour_path);
  } else if (const auto found = find_colour(device.depth)) {
    device.colour = *found;
  } else {
    return Error{device.depth.path, "no colour node on the same device; name it: ?color=/dev/videoM"};
  }
  const auto colour_format = format_of(device.colour, false, true);
  if (!colour_format) return colour_format.error();
  device.depth_format = *depth_format;
  device.colour_format = *colour_format;
  return device;
}

Result<Device> find_again(const Device& device) {
  Device found = device;
  bool depth = device.depth.interface.empty(), colour = device.colour.interface.empty();
  for (const NodePlace& place : find_nodes()) {
    if (!depth && place.same_socket(device.depth)) found.depth = place, depth = true;
    if (!colour && place.same_socket(device.colour)) found.colour = place, colour = true;
  }
  if (!depth || !colour) return Error{device.depth.path, "nothing is plugged in where the camera was"};
  if (found.depth.usb_id != device.depth.usb_id || found.depth.serial != device.depth.serial)
    return Error{found.depth.path, fmt::format("another device, {} {}, is plugged in where the camera was",
                                               found.depth.usb_id, found.depth.serial)};
  return found;
}

Result<imaging::RigCalibration> calibration_of(const V4l2Address& address, const Device& device, std::string& source) {
  if (!address.calibration_file.empty()) {
    source = address.calibration_file;
    const auto text = read_text_file(address.calibration_file, kSmallFileBytes);
    if (!text) return text.error();
    return imaging::parse_rig_calibration(*text, address.calibration_file);
  }
  const Model* model = find_model(device.depth.usb_id);
  if (!model)
    return Error{device.depth.path,
                 "no calibration is known for " +
                     (device.depth.usb_id.empty() ? "this device" : "USB device " + device.depth.usb_id) +
                     "; give ?calibration=FILE"};
  source = fmt::format("nominal for {}", model->name);
  return imaging::parse_rig_calibration(model->calibration, std::string(model->name));
}

}  // namespace onemap::hal::v4l2
