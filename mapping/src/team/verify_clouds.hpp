#pragma once
#include <vector>

#include "mapping/local/features.hpp"
#include "mapping/local/point_cloud.hpp"
#include "mapping/team/verify.hpp"

namespace onemap::mapping {

// A keyframe record unpacked for matching.
struct Cloud {
  FeatureSet features;
  std::vector<Vector3d> points;  // camera frame
  std::vector<Eigen::Vector2d> rays;
  OrganizedCloud grid;
  std::vector<Vector3f> cells;  // the grid's points
  Pose T_robot_keyframe;
};
Cloud unpack(const KeyframeRecord& record);

// A verified pair with its matched points, for the common fit.
struct Verified {
  PairResult result;
  std::uint32_t keyframe_r = 0, keyframe_s = 0;
  Pose T_a_r, T_b_s;                         // of the clouds in their robots' frames
  std::vector<Vector3d> points_r, points_s;  // inliers, camera frames
};
// result and points of the pair; whose clouds they are is the caller's to note.
Verified verify_clouds(const Cloud& r, const Cloud& s, const VerifyConfig& config);

// The transforms are taken to agree: within 8 cm at the point and 4 degrees.
inline constexpr double kAgree_m = 0.08, kAgreeCosine = 0.9976;

}  // namespace onemap::mapping
