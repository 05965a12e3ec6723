#include "local/exposure.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "floor_int.hpp"
#include "mapping/local/depth_range.hpp"

namespace onemap::mapping {
namespace {

constexpr int kOne = 256;
constexpr int kStride_px = 12;
constexpr std::uint32_t kLeastSamples = 200;
// A channel that is brighter does not say how bright; one of the sum of all below is mostly noise.
constexpr int kBrightest = 250, kLeastSum = 60;
constexpr int kSteady = kOne / 8;     // what vignetting and shine do to the median stays below it
constexpr int kMostRatio = 4 * kOne;  // that is told from more
constexpr int kLeastGain = kOne / 2, kMostGain = 2 * kOne;
constexpr int kWhite = 255, kShoulder = 220;  // from there on what is darkened leads back to white

// The colour of the map at a place, the sum of its channels; 0: none.
int map_colour(const VoxelMap& map, const Vector3d& p) {
  const double voxel_m = map.config().voxel_m;
  std::array<std::int32_t, 3> at{};
  for (int i = 0; i < 3; ++i) at[static_cast<std::size_t>(i)] = floor_int<std::int32_t>(p[i] / voxel_m);
  constexpr int kLow = kBlockSide - 1;
  const Voxel* block = map.find({at[0] >> 3, at[1] >> 3, at[2] >> 3});
  if (block == nullptr) return 0;
  const Voxel& voxel = block[((at[2] & kLow) * kBlockSide + (at[1] & kLow)) * kBlockSide + (at[0] & kLow)];
  if (voxel.color_weight == 0) return 0;
  return (voxel.rgb_sum[0] + voxel.rgb_sum[1] + voxel.rgb_sum[2]) / static_cast<int>(voxel.color_weight);
}

int scaled(int value, int gain) { return std::min((value * gain + kOne / 2) / kOne, kWhite); }

// A clipped channel does not say how bright it was: darkened, a white wall would be grey wherever the camera saw it
// over-exposed, with an edge to where it did not.
int evened_brightest(int value, int gain) {
  if (gain >= kOne || value <= kShoulder) return scaled(value, gain);
  const int below = scaled(kShoulder, gain);
  return below + ((kWhite - below) * (value - kShoulder) + (kWhite - kShoulder) / 2) / (kWhite - kShoulder);
}

}  // namespace

std::optional<int> brightness_ratio(const VoxelMap& map, const hal::FrameView& frame, const RayTable& rays,
                                    const Pose& T_map_camera) {
  if (frame.rgb.empty() || map.used() == 0) return std::nullopt;
  const hal::Intrinsics& k = *frame.intrinsics;
  const double farthest_m = std::min(map.config().max_depth_m, kMaxDepth_m);
  std::array<std::uint32_t, kMostRatio + 1> counts{};
  std::uint32_t samples = 0;
  for (int v = kStride_px / 2; v < k.height; v += kStride_px)
    for (int u = kStride_px / 2; u < k.width; u += kStride_px) {
      const std::size_t pixel =
          static_cast<std::size_t>(v) * static_cast<std::size_t>(k.width) + static_cast<std::size_t>(u);
      const double z = frame.depth[pixel] / k.depth_scale;
      if (!(z >= static_cast<double>(kMinDepth_m) && z <= farthest_m)) continue;
      const std::uint8_t* rgb = &frame.rgb[3 * pixel];
      const int sum = rgb[0] + rgb[1] + rgb[2];
      if (sum < kLeastSum || std::max({rgb[0], rgb[1], rgb[2]}) > kBrightest) continue;
      const float* ray = rays.row(v) + 2 * u;
      const int there = map_colour(map, T_map_camera * Vector3d(ray[0] * z, ray[1] * z, z));
      if (there < kLeastSum) continue;
      ++counts[static_cast<std::size_t>(std::min(kOne * there / sum, kMostRatio))];
      ++samples;
    }
  if (samples < kLeastSamples) return std::nullopt;
  std::uint32_t below = 0;
  int median = 0;
  while (2 * (below + counts[static_cast<std::size_t>(median)]) < samples)
    below += counts[static_cast<std::size_t>(median++)];
  return median;
}

void Exposure::measured(std::optional<int> ratio) {
  if (ratio) gain_ = std::abs(*ratio - kOne) <= kSteady ? kOne : std::clamp(*ratio, kLeastGain, kMostGain);
}

// The other channels of a bright pixel go as its brightest one does, so that it keeps its colour.
void Exposure::keep_white(std::span<const std::uint8_t> rgb) {
  std::array<int, kWhite + 1> to{};
  for (int i = 0; i <= kWhite; ++i) to[static_cast<std::size_t>(i)] = evened_brightest(i, gain_);
  for (std::size_t i = 0; i + 2 < rgb.size(); i += 3) {
    const int brightest = std::max({rgb[i], rgb[i + 1], rgb[i + 2]});
    if (brightest <= kShoulder) continue;
    const int evened = to[static_cast<std::size_t>(brightest)];
    for (std::size_t k = i; k < i + 3; ++k)
      evened_[k] = static_cast<std::uint8_t>((rgb[k] * evened + brightest / 2) / brightest);
  }
}

std::span<const std::uint8_t> Exposure::evened(std::span<const std::uint8_t> rgb) {
  if (gain_ == kOne) return rgb;
  std::array<std::uint8_t, kWhite + 1> to{};
  for (int i = 0; i <= kWhite; ++i) to[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(scaled(i, gain_));
  evened_.resize(rgb.size());
  std::ranges::transform(rgb, evened_.begin(), [&](std::uint8_t value) { return to[value]; });
  if (gain_ < kOne) keep_white(rgb);
  return evened_;
}

}  // namespace onemap::mapping
