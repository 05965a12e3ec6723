#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "hal/frame.hpp"
#include "mapping/geometry.hpp"
#include "mapping/local/ray_table.hpp"
#include "mapping/local/voxel_map.hpp"

namespace onemap::mapping {

// How much brighter than a frame the map is where both have a colour, in 256ths: the median over some of the frame's
// pixels; nullopt: they have too little in common.
std::optional<int> brightness_ratio(const VoxelMap& map, const hal::FrameView& frame, const RayTable& rays,
                                    const Pose& T_map_camera);

// Evens out what a camera's exposure does to its colours, so that a map has no seams where the exposure jumped. A gain
// near one is one: the images of a camera that keeps its exposure stay as they are, to the bit. It stays within a half
// and two: what was evened out is measured by next, and a room that is lit anew need not stay dark or turn
// white for ever.
class Exposure {
 public:
  explicit Exposure(std::size_t image_pixels) { evened_.reserve(3 * image_pixels); }
  // ratio: as brightness_ratio() says; nullopt: as the frame before.
  void measured(std::optional<int> ratio);
  int gain() const { return gain_; }  // in 256ths
  // The image with the gain on it, white staying white: itself, or one that is good until the next call.
  std::span<const std::uint8_t> evened(std::span<const std::uint8_t> rgb);
  std::size_t bytes() const { return evened_.capacity(); }

 private:
  void keep_white(std::span<const std::uint8_t> rgb);

  int gain_ = 256;
  std::vector<std::uint8_t> evened_;
};

}  // namespace onemap::mapping
