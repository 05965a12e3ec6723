#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "hal/base/result.hpp"
#include "hal/base/time.hpp"
#include "mapping/geometry.hpp"
#include "mapping/local/descriptor_bits.hpp"
#include "mapping/local/features.hpp"
#include "mapping/records/depth_grid.hpp"

namespace onemap::mapping {

// Where a feature lies: the pixel of the depth grid's pinhole, counted from the middle of the grid plus half the range,
// and the inverse depth, so that its error follows the sensor's. 13 bits each. For an image of 640 pixels a step is an
// eighth of a pixel; 0.001 / m is 4.5 mm at 3 m.
struct FeaturePlace {
  static constexpr int kBits = 13;
  static constexpr std::uint16_t kMost = (1 << kBits) - 1;
  static constexpr double kStepsPerPixel = 32, kStepsPerInverseMetre = 1000;

  std::uint16_t u = 0, v = 0;
  std::uint16_t inverse_depth = 1;  // 1 or more
  bool operator==(const FeaturePlace&) const = default;
};

// p in the camera's frame, metres. Nothing when it is beyond what a place can say: nearer than 12.3 cm, or so far
// outside the grid that no camera sees it there.
std::optional<FeaturePlace> to_place(const Vector3d& p, const DepthGrid& grid);
Eigen::Vector2d place_ray(const FeaturePlace& place, const DepthGrid& grid);  // undistorted, z = 1
Vector3d place_point(const FeaturePlace& place, const DepthGrid& grid);       // camera frame, metres; z > 0

struct KeyframeFeature {
  FeaturePlace place;
  std::int8_t laplacian = 0;  // surf_bits: -1 or 1; orb: 0
  DescriptorBits bits{};
};

struct KeyframeRecord {     // lane features
  std::uint32_t index = 0;  // the robot's own count, from 0
  FrameTime time{};
  QuantizedPose T_robot_keyframe;
  std::uint32_t anchor = 0;  // the keyframe, itself or an earlier one, whose submap what was seen around here is in
  DescriptorKind descriptor_kind = DescriptorKind::surf_bits;  // or orb; both have 256 bits
  std::vector<KeyframeFeature> features;                       // at most 1000, strongest first
  DepthGrid grid;
};

std::vector<std::uint8_t> encode(const KeyframeRecord& record);
Result<KeyframeRecord> decode_keyframe(std::span<const std::uint8_t> body);

}  // namespace onemap::mapping
