#pragma once
#include <cstdint>

#include "mapping/geometry.hpp"

namespace onemap::mapping {

// The keyframe in whose frame a submap's voxels lie: where the anchor moves, its surface goes with it.
struct SubmapAnchor {
  std::uint32_t keyframe = 0;  // the robot's own count
  Pose T_anchor_robot;
};

}  // namespace onemap::mapping
