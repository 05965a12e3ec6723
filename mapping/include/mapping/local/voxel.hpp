#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "mapping/geometry.hpp"
#include "mapping/local/block_key.hpp"

namespace onemap::mapping {

// Integer accumulators: sums of observations, so adding is exact and commutes as long as no sum saturates. The
// truncated signed distance of an observation is an integer -kTsdfOne..kTsdfOne (kTsdfOne = truncation distance in
// front of the surface). 12 bytes; weight 0 means never seen.
inline constexpr std::int32_t kTsdfOne = 1000;
struct Voxel {
  static constexpr int kMaxWeight = 8388;      // kMaxWeight * kTsdfOne fits tsdf_sum
  static constexpr int kMaxColorWeight = 255;  // 255 * 255 fits rgb_sum

  std::int32_t tsdf_sum : 24 = 0;  // sum of weight * tsdf
  std::uint32_t color_weight : 8 = 0;
  std::uint16_t weight = 0;                // sum of weights
  std::array<std::uint16_t, 3> rgb_sum{};  // sum of colour over color_weight

  // |value| <= kTsdfOne, 1 <= w <= kMaxWeight / 2. At saturation what was seen is halved first, sum and weight
  // together.
  void add_tsdf(int value, int w) {
    while (weight + w > kMaxWeight) {
      tsdf_sum = tsdf_sum / 2;
      weight = static_cast<std::uint16_t>((weight + 1) / 2);  // rounded up: the mean never leaves its range
    }
    tsdf_sum = tsdf_sum + w * value;
    weight = static_cast<std::uint16_t>(weight + w);
  }
  // One observed colour (weight 1).
  void add_color(int r, int g, int b) {
    if (color_weight == kMaxColorWeight) {
      for (auto& sum : rgb_sum) sum = static_cast<std::uint16_t>(sum / 2);
      color_weight = (kMaxColorWeight + 1) / 2;
    }
    rgb_sum[0] = static_cast<std::uint16_t>(rgb_sum[0] + r);
    rgb_sum[1] = static_cast<std::uint16_t>(rgb_sum[1] + g);
    rgb_sum[2] = static_cast<std::uint16_t>(rgb_sum[2] + b);
    color_weight = (color_weight + 1u) & 0xFFu;
  }
  // Whether so much more would saturate: then the order of adding begins to matter.
  bool would_saturate(int w) const { return weight + w > kMaxWeight; }
  bool color_would_saturate() const { return color_weight == kMaxColorWeight; }
  // Take back what was added, exactly, unless something saturated in between.
  void take_tsdf(int value, int w) {
    tsdf_sum = tsdf_sum - w * value;
    weight = static_cast<std::uint16_t>(weight - w);
  }
  void take_color(int r, int g, int b) {
    rgb_sum[0] = static_cast<std::uint16_t>(rgb_sum[0] - r);
    rgb_sum[1] = static_cast<std::uint16_t>(rgb_sum[1] - g);
    rgb_sum[2] = static_cast<std::uint16_t>(rgb_sum[2] - b);
    color_weight = (color_weight - 1u) & 0xFFu;
  }
  // Mean distance in units of the truncation / kTsdfOne, rounded to nearest; needs weight > 0.
  int tsdf() const {
    const int half = weight / 2;
    return tsdf_sum >= 0 ? (tsdf_sum + half) / weight : -((-tsdf_sum + half) / weight);
  }
  // Mean colour, rounded to nearest; black when none was seen.
  Rgb color() const {
    Rgb out{};
    if (color_weight == 0) return out;
    for (std::size_t i = 0; i < 3; ++i)
      out[i] = static_cast<std::uint8_t>((rgb_sum[i] + color_weight / 2) / color_weight);
    return out;
  }
  bool operator==(const Voxel&) const = default;
};
static_assert(sizeof(Voxel) == 12);

}  // namespace onemap::mapping
