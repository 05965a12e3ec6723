#pragma once
#include <cstdint>
#include <vector>

#include "keyframe_map.hpp"
#include "mapping/local/focal_check.hpp"
#include "mapping/local/fundamental.hpp"
#include "mapping/local/match.hpp"

namespace onemap::mapping {

// Shows the focal check each new keyframe beside an earlier one that looked in another direction. Memory is taken in
// the constructor.
class FocalWatch {
 public:
  FocalWatch(const hal::Intrinsics& intrinsics, const hal::DepthNoise& noise, std::size_t max_features,
             std::uint64_t seed);
  // The map's reference has just become a keyframe.
  void look(const KeyframeMap& map);
  FocalEstimate estimate() const { return check_.estimate(); }

 private:
  const MapKeyframe* turned_from(const KeyframeMap& map) const;

  Matcher matcher_;
  FundamentalRansac fundamental_;
  FocalCheck check_;
  std::vector<Eigen::Vector2d> ray_a_, ray_b_;
  std::vector<std::uint8_t> inlier_;
  std::vector<Vector3d> point_a_, point_b_;
};

}  // namespace onemap::mapping
