#pragma once
#include <optional>

#include "front_end.hpp"
#include "keyframe_map.hpp"
#include "landmark_fit.hpp"
#include "mapping/local/icp.hpp"
#include "motion.hpp"

namespace onemap::mapping {

// Where colour has little to say: the frame's depth against the reference keyframe's says where it is, with the few
// landmarks that are seen, each by its information; what neither says is taken from the motion.
struct Led {
  Pose T_camera_robot;
  PosePrior depth;        // what depth and motion say: the pull that a keyframe made of the frame keeps
  int inliers = 0;        // landmarks that agree
  bool all_seen = false;  // colour and depth tell all six directions
};

double mean_depth(std::span<const Vector3f> cloud);
// Whether information, of a left increment of T_camera_robot, tells all six directions to 1 cm (rotations: where they
// move a point at the mean depth).
bool sees_all(const Eigen::Matrix<double, 6, 6>& information, double mean_depth_m);

// What ICP says in the camera's frame, as information of a left increment of T_camera_robot; slides along a plane,
// which only the noise of its normals would hold, taken out.
PosePrior prior_of_depth(const IcpResult& icp, const Pose& T_reference_robot, double mean_depth_m);

// Whether a frame's depth alone would tell all six directions, had it been seen before. own: the frame's cloud,
// organised.
bool depth_sees_all(const OrganizedCloud& own, std::span<const Vector3f> cloud, const Icp& icp);

// How much of a cloud lies on a keyframe's surface, of what falls on it: 0..1, and 0 when too little of the cloud does.
double share_on_surface(const OrganizedCloud& target, std::span<const Vector3f> source, const Pose& T_target_source);

// None when depth does not say it either: too few points meet the reference, too many of them are off its surface, the
// camera would have jumped, or landmarks are missing that should be in the image (colour has something to say then, and
// it says no). known: the landmarks that features carry were found by matching, and are not looked for again.
std::optional<Led> lead_by_depth(Observed& seen, KeyframeMap& map, const Motion::Expected& expected, bool known,
                                 const Icp& icp, LandmarkFit& fit, const StepHook& begin);

}  // namespace onemap::mapping
