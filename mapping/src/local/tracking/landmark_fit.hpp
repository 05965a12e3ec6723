#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "guided_search.hpp"
#include "hal/frame.hpp"
#include "pose_refiner.hpp"

namespace onemap::mapping {

// The last word on where a camera is: landmarks are looked for near where they should be, and the pose moves to the
// least reprojection error over those that were found. Memory is taken in the constructor.
class LandmarkFit {
 public:
  LandmarkFit(const hal::Intrinsics& intrinsics, std::size_t max_features);
  // features.landmark: in, what is known to be seen; out, what the pose agrees with. T_camera_robot: in, a guess.
  // Counts in the landmarks how often they were visible and found. Returns the inliers.
  int fit(FeatureFrame& features, LandmarkMap& map, std::span<const std::int32_t> near, const PosePrior* prior,
          Pose& T_camera_robot);
  // Of the last fit: the landmarks that should have been in the image, and what those found say of the pose.
  int expected() const { return search_.expected(); }
  Eigen::Matrix<double, 6, 6> information(const Pose& T_camera_robot) const {
    return information_of(observations_, focal_px_, T_camera_robot);
  }

 private:
  void observe(const FeatureFrame& features, const LandmarkMap& map);
  void keep_inliers(FeatureFrame& features, LandmarkMap& map) const;

  double focal_px_;
  GuidedSearch search_;
  std::vector<PoseObservation> observations_;
  std::vector<std::uint32_t> feature_of_;  // of each observation
};

}  // namespace onemap::mapping
