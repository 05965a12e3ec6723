#pragma once
#include <vector>

#include "mapping/local/feature_cloud.hpp"
#include "mapping/local/organized_cloud.hpp"
#include "mapping/team/verify.hpp"

namespace onemap::mapping {

// A keyframe record unpacked for matching. The first of a pair needs normals: ICP aligns the second to it.
struct Cloud {
  FeatureCloud features;
  OrganizedCloud grid;
  std::vector<Vector3f> cells;  // every second row and column of the grid's points
  Pose T_robot_keyframe;
};
Cloud unpack(const KeyframeRecord& record, Normals normals = Normals::fitted);

// One pair of clouds r of robot a, s of robot b (the paper, section 4): matches, fundamental matrix, depth check, 3D
// RANSAC, ICP on the depth grids.
struct PairResult {
  LinkReason reason = LinkReason::too_few_matches;
  int matches = 0, inliers = 0;
  double ratio = 0;            // quality: inliers / min(features of r, features of s)
  double error_m = 0;          // ICP's rms
  std::uint32_t measured = 0;  // see LinkReason, of a refusal
  Pose T_r_s;
};

// A verified pair with its matched points, for the common fit.
struct Verified {
  PairResult result;
  std::uint32_t keyframe_r = 0, keyframe_s = 0;
  Pose T_a_r, T_b_s;                         // of the clouds in their robots' frames
  std::vector<Vector3d> points_r, points_s;  // inliers, camera frames
};
// result and points of the pair; whose clouds they are is the caller's to note. Both have one kind of features.
Verified verify_clouds(const Cloud& r, const Cloud& s, const VerifyConfig& config);

// The transforms are taken to agree: within 8 cm at the point and 4 degrees.
inline constexpr double kAgree_m = 0.08, kAgreeCosine = 0.9976;

}  // namespace onemap::mapping
