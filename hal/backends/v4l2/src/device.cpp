#include "device.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string_view>

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

Result<NodePlace> find_depth(const V4l2Address& address) {
  if (!address.depth_path.empty()) return place_of(address.depth_path);
  const std::vector<NodePlace> nodes = find_nodes();
  std::string seen;
  std::optional<NodePlace> lone;  // without colour
  for (const NodePlace& place : nodes) {
    const auto node = Node::open(place.path);
    if (node && depth_format(node->formats(), false) != 0) {
      if (!address.colour_path.empty() || find_colour(place)) return place;
      if (!lone) lone = place;
      continue;
    }
    seen += node ? fmt::format("; {} ({}): no depth format", place.path, node->card())
                 : fmt::format("; {}", node.error().text());
  }
  if (lone) return *lone;
  return Error{"camera address '" + address.text + "'",
               fmt::format("no depth camera among the {} video nodes{}", nodes.size(), seen)};
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

namespace {

using imaging::ImageSize;

struct Shipped {
  std::string_view name;
  imaging::RigCalibration rig;
};

// The smallest images' first, which are the ones that are taken when no size is named.
Result<std::vector<Shipped>> shipped_for(const NodePlace& place) {
  std::vector<Shipped> all;
  for (const Model* model : find_models(place.usb_id)) {
    const auto rig = imaging::parse_rig_calibration(model->calibration, std::string(model->name));
    if (!rig) return rig.error();
    all.push_back({model->name, *rig});
  }
  if (all.empty())
    return Error{place.path, "no calibration is known for " +
                                 (place.usb_id.empty() ? "this device" : "USB device " + place.usb_id) +
                                 "; give ?calibration=FILE"};
  std::ranges::sort(all, {}, [](const Shipped& s) { return imaging::size_of(s.rig.colour).pixels(); });
  return all;
}

// Of these the one whose lens has images of this shape.
Result<const Shipped*> of_shape(const std::vector<Shipped>& all, ImageSize size, bool depth) {
  std::string known;
  for (const Shipped& one : all) {
    const Intrinsics& lens = depth && one.rig.depth ? *one.rig.depth : one.rig.colour;
    if (imaging::scaled_to(lens, size)) return &one;
    known += fmt::format(" {}x{}", lens.width, lens.height);
  }
  return Error{std::string(all.front().name),
               fmt::format("no nominal calibration for {} images of {}x{}; there are those of{} and of their shapes; "
                           "give ?calibration=FILE",
                           depth ? "depth" : "colour", size.width, size.height, known)};
}

// Of the sizes that are wanted: colour and depth may have theirs from two calibrations of one body.
Result<imaging::RigCalibration> shipped_calibration(const NodePlace& place, const std::optional<ImageSize>& colour,
                                                    const std::optional<ImageSize>& depth, std::string& source) {
  const auto all = shipped_for(place);
  if (!all) return all.error();
  const auto one = colour ? of_shape(*all, *colour, false) : Result<const Shipped*>(&all->front());
  if (!one) return one.error();
  const auto other = depth ? of_shape(*all, *depth, true) : one;
  if (!other) return other.error();
  imaging::RigCalibration rig = (*one)->rig;
  rig.depth = (*other)->rig.depth;
  rig.noise = (*other)->rig.noise;
  source = fmt::format("nominal for {}", (*one)->name);
  if (*other != *one) source += fmt::format(", depth's for {}", (*other)->name);
  return rig;
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

// A USB 3 device calls itself a 2.1 one on a USB 2 port, one that was made for USB 2 a 2.0.
std::string limits_of(const NodePlace& node) {
  if (node.speed != "480" && node.speed != "12" && node.speed != "1.5") return {};
  const std::size_t digit = node.usb_version.find_first_not_of(' ');
  if (node.speed == "480" && digit != std::string::npos && node.usb_version.substr(digit) < "2.10") return {};
  return fmt::format(
      "is on {} ({} Mbit/s), where it has fewer sizes and frame rates than on USB 3: another port or cable changes "
      "that",
      node.speed == "480" ? "USB 2" : "USB 1", node.speed);
}

Result<imaging::RigCalibration> calibration_of(const V4l2Address& address, const Device& device, std::string& source) {
  if (!address.calibration_file.empty()) {
    source = address.calibration_file;
    const auto text = read_text_file(address.calibration_file, kSmallFileBytes);
    if (!text) return text.error();
    return imaging::parse_rig_calibration(*text, address.calibration_file);
  }
  return shipped_calibration(device.depth, address.size, address.depth_size, source);
}

}  // namespace onemap::hal::v4l2
