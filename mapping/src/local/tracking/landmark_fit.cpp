#include "landmark_fit.hpp"

#include <algorithm>

namespace onemap::mapping {

namespace {
constexpr std::int32_t kOrbDistance = 60;  // bits; for SURF the search's own
}

LandmarkFit::LandmarkFit(const hal::Intrinsics& k, std::size_t max_features)
    : focal_px_(0.5 * (k.fx + k.fy)), search_(k, max_features) {
  observations_.reserve(max_features);
  feature_of_.reserve(max_features);
}

int LandmarkFit::fit(FeatureFrame& features, LandmarkMap& map, std::span<const std::int32_t> near,
                     const PosePrior* prior, Pose& T_camera_robot) {
  SearchConfig config;
  if (features.set.kind == DescriptorKind::orb) config.max_distance = kOrbDistance;
  search_.index(features);
  search_.find(map, near, T_camera_robot, config, features);
  observe(features, map);
  const RefineResult result = refine_pose(observations_, focal_px_, prior, T_camera_robot);
  keep_inliers(features, map);
  return result.inliers;
}

void LandmarkFit::observe(const FeatureFrame& features, const LandmarkMap& map) {
  observations_.clear();
  feature_of_.clear();
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (features.landmark[i] < 0) continue;
    observations_.push_back({map.landmark(features.landmark[i]).p_robot,
                             {features.ray[i], features.inverse_depth(i), weight_of(features.set.keypoints[i])},
                             true});
    feature_of_.push_back(static_cast<std::uint32_t>(i));
  }
}

void LandmarkFit::keep_inliers(FeatureFrame& features, LandmarkMap& map) const {
  for (std::size_t i = 0; i < observations_.size(); ++i) {
    std::int32_t& id = features.landmark[feature_of_[i]];
    if (observations_[i].inlier)
      ++map.landmark(id).found;
    else
      id = -1;
  }
}

}  // namespace onemap::mapping
