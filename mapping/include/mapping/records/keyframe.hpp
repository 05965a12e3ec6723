#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "hal/base/result.hpp"
#include "hal/base/time.hpp"
#include "mapping/geometry.hpp"
#include "mapping/local/features.hpp"

namespace onemap::mapping {

inline constexpr double kPointUnit_m = 0.00025;  // unit of the int16 points and depths: 0.25 mm, so +-8.19 m

struct KeyframeFeature {
  std::array<std::int16_t, 3> point{};  // camera frame, units of kPointUnit_m; z > 0
  std::int8_t laplacian = 0;
  Descriptor descriptor;
};

// A depth image on an ideal pinhole grid (see OrganizedCloud), coarse: for ICP between robots.
struct DepthGrid {
  std::uint16_t width = 0, height = 0;        // at most 160 x 120
  std::array<std::int32_t, 4> fx_fy_cx_cy{};  // pixels of this grid, units of 1/1024
  std::vector<std::uint16_t> depth;           // units of kPointUnit_m, 0 = none; row by row
};

struct KeyframeRecord {     // lane features
  std::uint32_t index = 0;  // the robot's own count, from 0
  FrameTime time{};
  QuantizedPose T_robot_keyframe;
  std::uint32_t anchor = 0;  // the keyframe, itself or an earlier one, whose submap what was seen around here is in
  DescriptorKind descriptor_kind = DescriptorKind::surf;
  std::vector<KeyframeFeature> features;  // at most 1000
  DepthGrid grid;
};

std::vector<std::uint8_t> encode(const KeyframeRecord& record);
Result<KeyframeRecord> decode_keyframe(std::span<const std::uint8_t> body);

}  // namespace onemap::mapping
