#include "pose_refiner.hpp"

#include <Eigen/Cholesky>

namespace onemap::mapping {

namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
constexpr int kRounds = 3, kIterations = 5;
constexpr double kMinZ_m = 0.02;

Matrix3d skew(const Vector3d& v) {
  Matrix3d S;
  S << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return S;
}

void accumulate(const PoseObservation& obs, double focal_px, const Pose& T, Matrix6d& H, Vector6d& g) {
  const Vector3d p = T * obs.p_robot;
  if (p.z() < kMinZ_m) return;
  const Vector3d r = residual(p, obs.o, focal_px);
  const double chi2 = obs.o.weight * r.squaredNorm();
  const double w = obs.o.weight * huber_weight(chi2, chi2_bound(obs.o));
  const Eigen::Matrix<double, 3, 6> J = residual_by_point(p, obs.o, focal_px) * point_by_motion(p);
  H.noalias() += w * J.transpose() * J;
  g.noalias() += w * J.transpose() * r;
}

bool step(std::span<const PoseObservation> observations, double focal_px, const PosePrior* prior, Pose& T) {
  Matrix6d H = Matrix6d::Identity() * 1e-6;
  Vector6d g = Vector6d::Zero();
  for (const PoseObservation& obs : observations)
    if (obs.inlier) accumulate(obs, focal_px, T, H, g);
  if (prior) {
    H += prior->information;
    g += prior->information * motion_between(prior->T_camera_robot, T);
  }
  const Vector6d d = H.ldlt().solve(-g);
  if (!d.allFinite()) return false;
  T = small_motion(d) * T;
  T.R = orthonormal(T.R);
  return d.squaredNorm() > 1e-12;
}

RefineResult classify(std::span<PoseObservation> observations, double focal_px, const Pose& T) {
  RefineResult result;
  double sum = 0;
  for (PoseObservation& obs : observations) {
    const Vector3d p = T * obs.p_robot;
    const double squared = p.z() < kMinZ_m ? 1e9 : residual(p, obs.o, focal_px).squaredNorm();
    obs.inlier = obs.o.weight * squared <= chi2_bound(obs.o);
    if (!obs.inlier) continue;
    ++result.inliers;
    sum += squared;
  }
  result.rms_px = result.inliers > 0 ? std::sqrt(sum / result.inliers) : 0;
  return result;
}

}  // namespace

RefineResult refine_pose(std::span<PoseObservation> observations, double focal_px, const PosePrior* prior, Pose& T) {
  RefineResult result;
  for (int round = 0; round < kRounds; ++round) {
    for (int i = 0; i < kIterations; ++i)
      if (!step(observations, focal_px, prior, T)) break;
    result = classify(observations, focal_px, T);
    if (result.inliers < 6) break;
  }
  return result;
}

Eigen::Matrix<double, 6, 6> information_of(std::span<const PoseObservation> observations, double focal_px,
                                           const Pose& T) {
  Matrix6d H = Matrix6d::Zero();
  Vector6d g = Vector6d::Zero();
  for (const PoseObservation& obs : observations)
    if (obs.inlier) accumulate(obs, focal_px, T, H, g);
  return H;
}

Eigen::Matrix<double, 6, 6> information_of_inverse(const Matrix6d& information, const Pose& T) {
  // T' = exp(d) T  =>  T'^-1 = exp(-Ad(T^-1) d) T^-1, so d = -Ad(T) e for an increment e of the inverse.
  Matrix6d Ad = Matrix6d::Zero();
  Ad.topLeftCorner<3, 3>() = T.R;
  Ad.bottomRightCorner<3, 3>() = T.R;
  Ad.bottomLeftCorner<3, 3>() = skew(T.t) * T.R;
  return Ad.transpose() * information * Ad;
}

}  // namespace onemap::mapping
