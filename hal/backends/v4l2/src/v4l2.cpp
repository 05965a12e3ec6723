#include "hal/backends/v4l2.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

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

constexpr int kUsual_hz = 30;  // what an address without fps= asks for

// Both nodes' frames a second at the sizes that the calibration has: the most up to 30 that both have, else the least
// above; 30 when a driver does not say. An error when they cannot be opened so.
Result<int> rate_of(const Device& device, const imaging::RigCalibration& rig) {
  std::vector<int> common;
  bool known = true;
  for (const bool depth : {true, false}) {
    const NodePlace& place = depth ? device.depth : device.colour;
    const FourCc format = depth ? device.depth_format : device.colour_format;
    const imaging::ImageSize size = imaging::size_of(depth && rig.depth ? *rig.depth : rig.colour);
    const auto node = Node::open(place.path);
    if (!node) return node.error();
    const std::string mode = fmt::format("{} {}x{}", text_of(format), size.width, size.height);
    if (!node->has_size(format, size))
      return Error{place.path,
                   fmt::format("has no {}, which its calibration is for; it has {}", mode, node->sizes(format))};
    const std::vector<int> rates = node->rates(format, size);
    known = known && !rates.empty();
    if (depth) common = rates;
    std::erase_if(common, [&](int hz) { return std::ranges::find(rates, hz) == rates.end(); });
  }
  if (!known) return kUsual_hz;
  if (common.empty()) return Error{device.depth.path, "depth and colour have no frame rate in common"};
  const auto best = std::ranges::find_if(common, [](int hz) { return hz <= kUsual_hz; });
  return best != common.end() ? *best : common.back();
}

struct Listed {
  CameraInfo info;
  int lacks = 0;  // the less, the better
};
constexpr int kUnusable = 1000;

Listed unusable(const NodePlace& place, const std::string& why) {
  return {{"v4l2:" + place.path, people_call_it(place), "", why}, kUnusable};
}

Listed describe(const NodePlace& depth) {
  V4l2Address address;
  address.text = "v4l2:" + depth.path;
  address.depth_path = depth.path;
  const auto device = find_device(address);
  if (!device) return unusable(depth, device.error().text());
  CameraInfo info{address.text, people_call_it(depth), abilities_of(*device), "", limits_of(depth)};
  std::string source;
  const auto rig = calibration_of(address, *device, source);
  const auto rate = rig ? rate_of(*device, *rig) : Result<int>(kUsual_hz);
  if (rig) info.abilities += "; calibration " + source;
  if (!rig) info.problem = rig.error().reason;
  if (!rate) info.problem = rate.error().text();
  if (!info.problem.empty()) return {std::move(info), kUnusable};
  if (*rate != kUsual_hz) {
    info.address += fmt::format("?fps={}", *rate);
    info.limits += fmt::format("{}gives {} frames a second, not {}", info.limits.empty() ? "" : "; ", *rate, kUsual_hz);
  }
  const int lacks = (info.limits.empty() ? 0 : 1) + std::max(0, kUsual_hz - *rate);
  return {std::move(info), lacks};
}

// Nothing: it is no depth camera, or a part of one that is listed by another node.
std::optional<Listed> camera_at(const NodePlace& place, const std::vector<NodePlace>& with_z16) {
  const auto node = Node::open(place.path);
  if (!node && node.error().reason == Node::kNoCapture) return std::nullopt;
  if (!node) return unusable(place, node.error().text());
  const std::vector<FourCc> formats = node->formats();
  if (depth_format(formats, false) != 0) return describe(place);
  const auto same_body = [&](const NodePlace& other) { return !place.device.empty() && other.device == place.device; };
  if (depth_format(formats, true) == 0 || std::ranges::any_of(with_z16, same_body)) return std::nullopt;
  Listed listed = describe(place);
  const std::string may_be =
      "offers Y16, which is depth or infrared, and no Z16: where it is depth, name it as camera, " +
      listed.info.address;
  listed.info.problem = listed.info.problem.empty() ? may_be : may_be + "; and then: " + listed.info.problem;
  listed.lacks = kUnusable;
  return listed;
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
  const std::vector<NodePlace> nodes = find_nodes();
  std::vector<NodePlace> with_z16;
  for (const NodePlace& place : nodes)
    if (const auto node = Node::open(place.path); node && depth_format(node->formats(), false) != 0)
      with_z16.push_back(place);
  std::vector<Listed> all;
  for (const NodePlace& place : nodes)
    if (auto listed = camera_at(place, with_z16)) all.push_back(std::move(*listed));
  std::ranges::stable_sort(all, {}, &Listed::lacks);
  std::vector<CameraInfo> cameras;
  cameras.reserve(all.size());
  for (Listed& one : all) cameras.push_back(std::move(one.info));
  return cameras;
}

}  // namespace onemap::hal
