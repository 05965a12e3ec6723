#include "depth_lead.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace onemap::mapping {

namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Eigensolver = Eigen::SelfAdjointEigenSolver<Matrix6d>;

// Neighbouring depths err alike, so many points say less than their number.
constexpr double kDepthWeight = 0.1;
// What the normals' noise (about 2 degrees) says of a slide along a plane, as a share of what all points say.
constexpr double kNormalNoise = 1e-3;
constexpr double kSeen_m = 0.01;                        // a direction that is surer than this is seen
constexpr double kJump_m = 0.10, kJumpCosine = 0.9903;  // 8 degrees, from where the camera is expected
constexpr double kLeastOverlap = 0.3, kLeastAgreement = 0.6, kNearSurface_m = 0.015;
constexpr int kTellingLandmarks = 40, kFoundShare = 8;  // so many should be seen, and one of so many is

// Rotations measured by how far they move a point at the mean depth: all six directions in metres.
Matrix6d in_metres(const Matrix6d& information, double depth_m) {
  Vector6d scale;
  scale << Vector3d::Constant(1 / depth_m), Vector3d::Ones();
  return scale.asDiagonal() * information * scale.asDiagonal();
}

// What two say together; b rules where a says nothing.
PosePrior both(const PosePrior& a, const PosePrior& b) {
  const Matrix6d information = a.information + b.information;
  const Vector6d to_a = motion_between(b.T_camera_robot, a.T_camera_robot);
  const Vector6d step = information.ldlt().solve(a.information * to_a);
  return {small_motion(step) * b.T_camera_robot, information};
}

bool jumps(const Pose& from, const Pose& to) {
  const Pose d = to * from.inverse();
  return d.t.squaredNorm() > kJump_m * kJump_m || rotation_cosine(d.R) < kJumpCosine;
}

}  // namespace

double mean_depth(std::span<const Vector3f> cloud) {
  double sum = 0;
  for (const Vector3f& p : cloud) sum += static_cast<double>(p.z());
  return cloud.empty() ? 1 : std::max(0.1, sum / static_cast<double>(cloud.size()));
}

bool sees_all(const Matrix6d& information, double depth_m) {
  return Eigensolver(in_metres(information, depth_m), Eigen::EigenvaluesOnly).eigenvalues()[0] >
         1 / (kSeen_m * kSeen_m);
}

PosePrior prior_of_depth(const IcpResult& icp, const Pose& T_reference_robot, double mean_depth_m) {
  const Matrix6d all = in_metres(information_of_inverse(icp.information, icp.T_target_source), mean_depth_m);
  const Eigensolver by_direction(all);
  const Vector6d kept = (by_direction.eigenvalues().array() - kNormalNoise * icp.weight).max(0.0);
  const Matrix6d trimmed = by_direction.eigenvectors() * kept.asDiagonal() * by_direction.eigenvectors().transpose();
  return {icp.T_target_source.inverse() * T_reference_robot, kDepthWeight * in_metres(trimmed, 1 / mean_depth_m)};
}

double share_on_surface(const OrganizedCloud& target, std::span<const Vector3f> source, const Pose& T) {
  std::size_t met = 0, on = 0;
  for (const Vector3f& s : source) {
    const Vector3d p = T * s.cast<double>();
    if (!(p.z() >= static_cast<double>(kMinDepth_m))) continue;
    const double u = target.fx * p.x() / p.z() + target.cx + 0.5, v = target.fy * p.y() / p.z() + target.cy + 0.5;
    if (!(u >= 0 && v >= 0 && u < target.width && v < target.height)) continue;
    const auto i = target.index(static_cast<int>(u), static_cast<int>(v));
    if (target.points[i].z() == 0 || target.normals[i].squaredNorm() == 0) continue;
    ++met;
    const Vector3d q = target.points[i].cast<double>();
    on += std::abs(target.normals[i].cast<double>().dot(p - q)) <
          std::max(kNearSurface_m, 3 * target.noise.sigma_m(q.z()));
  }
  if (static_cast<double>(met) < kLeastOverlap * static_cast<double>(source.size())) return 0;
  return met == 0 ? 0 : static_cast<double>(on) / static_cast<double>(met);
}

std::optional<Led> lead_by_depth(Observed& seen, KeyframeMap& map, const Motion::Expected& expected, bool known,
                                 const Icp& icp, LandmarkFit& fit, const StepHook& begin) {
  begin(Step::icp);
  const Pose T_reference_robot = map.reference().T_camera_robot;
  const Pose guess = T_reference_robot * expected.T_camera_robot.inverse();
  const Matrix6d hold = information_of_inverse(expected.information, guess.inverse());
  const IcpResult found = icp.align(map.reference_cloud(), seen.cloud, guess, &hold);
  if (found.reason == IcpReason::too_few_inliers) return std::nullopt;
  if (share_on_surface(map.reference_cloud(), seen.cloud, found.T_target_source) < kLeastAgreement) return std::nullopt;
  const double depth_m = mean_depth(seen.cloud);
  Led led;
  led.depth = prior_of_depth(found, T_reference_robot, depth_m);
  const Matrix6d by_depth = led.depth.information;
  led.depth = both(led.depth, {expected.T_camera_robot, expected.information});
  if (jumps(expected.T_camera_robot, led.depth.T_camera_robot)) return std::nullopt;

  begin(Step::refine);
  if (!known) std::fill(seen.features.landmark.begin(), seen.features.landmark.end(), -1);
  led.T_camera_robot = led.depth.T_camera_robot;
  led.inliers = fit.fit(seen.features, map.landmarks(), map.near(), &led.depth, led.T_camera_robot);
  if (!known && fit.expected() >= kTellingLandmarks && kFoundShare * led.inliers < fit.expected()) return std::nullopt;
  led.all_seen = sees_all(by_depth + fit.information(led.T_camera_robot), depth_m);
  return led;
}

bool depth_sees_all(const OrganizedCloud& own, std::span<const Vector3f> cloud, const Icp& icp) {
  const IcpResult alone = icp.align(own, cloud, Pose{});
  if (alone.reason == IcpReason::too_few_inliers) return false;
  const double depth_m = mean_depth(cloud);
  return sees_all(prior_of_depth(alone, Pose{}, depth_m).information, depth_m);
}

}  // namespace onemap::mapping
