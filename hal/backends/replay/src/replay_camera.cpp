#include "replay_camera.hpp"

#include <cassert>
#include <utility>

#include "file.hpp"

namespace onemap::hal::replay {

ReplayCamera::ReplayCamera(Recording recording) : recording_(std::move(recording)), next_(recording_.from) {
  counters_.unmatched = recording_.unmatched;
}

Result<std::unique_ptr<DepthCamera>> ReplayCamera::open(Recording recording) {
  std::unique_ptr<ReplayCamera> camera(new ReplayCamera(std::move(recording)));
  if (const Status status = camera->find_size(); !status) return status.error();
  return std::unique_ptr<DepthCamera>(std::move(camera));
}

Status ReplayCamera::find_size() {
  Error first;
  for (std::size_t i = recording_.from; i < recording_.to; ++i) {
    ImageSize size;
    Status status = size_of(recording_.pairs[i], size);
    if (status) {
      const std::size_t pixels = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
      std::vector<std::uint8_t> rgb(3 * pixels);
      std::vector<std::uint16_t> depth(pixels);
      status = read_pair(recording_.pairs[i], size, rgb, depth);
    }
    if (status) {
      recording_.intrinsics.width = size.width;
      recording_.intrinsics.height = size.height;
      return success();
    }
    if (i == recording_.from) first = status.error();
  }
  first.reason += " (and no other frame can be read)";
  return first;
}

Status ReplayCamera::size_of(const ListedPair& pair, ImageSize& size) {
  if (const Status status = load(pair.color, "colour"); !status) return status.error();
  const Result<ImageSize> found = image_size(file_);
  if (!found) return at_file(pair.color, "colour", found.error().reason);
  size = *found;
  return success();
}

Error ReplayCamera::at_file(const ListedImage& image, const char* kind, const std::string& reason) const {
  std::string where = std::string(" (") + kind + " image";
  if (image.line > 0) where += " of line " + std::to_string(image.line);
  return {(recording_.folder / image.path).string(), reason + where + ")"};
}

Status ReplayCamera::load(const ListedImage& image, const char* kind) {
  const Status status = read_file(recording_.folder / image.path, file_);
  if (!status) return at_file(image, kind, status.error().reason);
  return success();
}

Status ReplayCamera::read_pair(const ListedPair& pair, ImageSize size, std::span<std::uint8_t> rgb,
                               std::span<std::uint16_t> depth) {
  if (const Status status = load(pair.color, "colour"); !status) return status.error();
  if (const Status status = decode_color(file_, size, rgb); !status)
    return at_file(pair.color, "colour", status.error().reason);
  if (const Status status = load(pair.depth, "depth"); !status) return status.error();
  if (const Status status = decode_depth(file_, size, depth); !status)
    return at_file(pair.depth, "depth", status.error().reason);
  if (recording_.max_depth_is_none)
    for (std::uint16_t& value : depth) value = value == 65535 ? std::uint16_t{0} : value;
  return success();
}

Grab ReplayCamera::grab(Frame& into, std::chrono::milliseconds) {
  if (problems_told_ < recording_.problems.size()) {
    last_error_ = recording_.problems[problems_told_++];
    ++counters_.bad;
    return Grab::bad;
  }
  if (next_ == recording_.to) return Grab::end;
  const std::size_t at = next_++;
  const ListedPair& pair = recording_.pairs[at];
  const ImageSize size{recording_.intrinsics.width, recording_.intrinsics.height};
  if (const Status status = read_pair(pair, size, into.rgb(), into.depth()); !status) {
    last_error_ = status.error();
    ++counters_.bad;
    return Grab::bad;
  }
  into.time = pair.color.time;
  into.index = at - recording_.from;
  ++counters_.frames;
  return Grab::frame;
}

std::string ReplayCamera::description() const {
  const auto text = [](auto value) { return std::to_string(value); };
  return "replay of " + recording_.folder.string() + (recording_.layout == Layout::tum ? " (TUM" : " (7-Scenes") +
         " layout), " + text(recording_.intrinsics.width) + "x" + text(recording_.intrinsics.height) + ", frames " +
         text(recording_.from) + " to " + text(recording_.to) + " of " + text(recording_.pairs.size()) +
         ", calibration: " + recording_.calibration_source;
}

}  // namespace onemap::hal::replay
