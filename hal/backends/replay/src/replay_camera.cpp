#include "replay_camera.hpp"

#include <fmt/format.h>

#include <utility>

#include "hal/base/file.hpp"

namespace onemap::hal::replay {

namespace {
constexpr std::size_t kMostImageBytes = 256u << 20;
}

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
    imaging::ImageSize size;
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
      return recording_.calibration.check(size.width, size.height);
    }
    if (i == recording_.from) first = status.error();
  }
  first.reason += " (and no other frame can be read)";
  return first;
}

Status ReplayCamera::size_of(const ListedPair& pair, imaging::ImageSize& size) {
  if (const Status status = load(pair.color, recording_.color_list); !status) return status.error();
  const Result<imaging::ImageSize> found = imaging::image_size(file_);
  if (!found) return at_file(pair.color, recording_.color_list, found.error().reason);
  size = *found;
  return success();
}

Error ReplayCamera::at_file(const ListedImage& image, const std::string& list, const std::string& reason) const {
  Error error{(recording_.folder / image.path).string(), reason};
  if (!list.empty()) error.reason += fmt::format(" (named in {}:{})", list, image.line);
  return error;
}

Status ReplayCamera::load(const ListedImage& image, const std::string& list) {
  const Status status = read_regular_file((recording_.folder / image.path).string(), file_, kMostImageBytes);
  if (!status) return at_file(image, list, status.error().reason);
  return success();
}

Status ReplayCamera::read_pair(const ListedPair& pair, imaging::ImageSize size, std::span<std::uint8_t> rgb,
                               std::span<std::uint16_t> depth) {
  if (const Status status = load(pair.color, recording_.color_list); !status) return status.error();
  if (const Status status = imaging::decode_color(file_, size, rgb); !status)
    return at_file(pair.color, recording_.color_list, status.error().reason);
  if (const Status status = load(pair.depth, recording_.depth_list); !status) return status.error();
  if (const Status status = imaging::decode_depth(file_, size, depth); !status)
    return at_file(pair.depth, recording_.depth_list, status.error().reason);
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
  const imaging::ImageSize size{recording_.intrinsics.width, recording_.intrinsics.height};
  if (const Status status = read_pair(pair, size, into.rgb(), into.depth()); !status) {
    last_error_ = status.error();
    ++counters_.bad;
    return Grab::bad;
  }
  into.colour_time = pair.color.time;
  into.depth_time = recording_.own_depth_time ? pair.depth.time : pair.color.time;
  into.index = at - recording_.from;
  ++counters_.frames;
  return Grab::frame;
}

std::string ReplayCamera::description() const {
  const Intrinsics& k = recording_.intrinsics;
  return fmt::format("replay of {} ({} layout), {}x{}, frames {} to {} of {}, calibration: {}",
                     recording_.folder.string(), recording_.layout == Layout::tum ? "TUM" : "7-Scenes", k.width,
                     k.height, recording_.from, recording_.to, recording_.pairs.size(), recording_.calibration_source);
}

}  // namespace onemap::hal::replay
