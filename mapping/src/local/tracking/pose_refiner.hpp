#pragma once
#include <cstdint>
#include <span>

#include "reprojection.hpp"

namespace onemap::mapping {

struct PoseObservation {
  Vector3d p_robot;
  Observation o;
  bool inlier = true;
};

// A quadratic pull towards a pose found otherwise (ICP): 0.5 d^T information d, d the left motion from it to the
// estimate.
struct PosePrior {
  Pose T_camera_robot;
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
};

struct RefineResult {
  int inliers = 0;
  double rms_px = 0;  // of the inliers
};

// Moves T_camera_robot to the least reprojection error over the observations (Gauss-Newton with Huber weights, in
// rounds: after each the outliers are marked and left out) plus an optional prior.
RefineResult refine_pose(std::span<PoseObservation> observations, double focal_px, const PosePrior* prior,
                         Pose& T_camera_robot);

// What the inliers say of an increment of T_camera_robot.
Eigen::Matrix<double, 6, 6> information_of(std::span<const PoseObservation> observations, double focal_px,
                                           const Pose& T_camera_robot);

// The information of an increment of T_target_source moved to one of T_source_target (the adjoint on both sides).
Eigen::Matrix<double, 6, 6> information_of_inverse(const Eigen::Matrix<double, 6, 6>& information,
                                                   const Pose& T_target_source);

}  // namespace onemap::mapping
