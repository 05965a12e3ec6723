#include "mapping/local/icp.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "local/sensor_noise.hpp"

namespace onemap::mapping {

std::string_view to_string(IcpReason reason) {
  switch (reason) {
    case IcpReason::converged:
      return "converged";
    case IcpReason::iteration_limit:
      return "iteration_limit";
    case IcpReason::too_few_inliers:
      return "too_few_inliers";
    case IcpReason::degenerate:
      return "degenerate";
  }
  return "unknown";
}

namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

constexpr double kNoiseSigmas = 3;       // the robust scale never falls below the sensor's noise
constexpr double kShrink = 0.6;          // of the robust scale, an iteration
constexpr double kLastRobust_m = 0.003;  // below it the noise rules
constexpr double kFlicker = 10;    // steps this near to the stop that no longer shrink: points flip between two cells
constexpr double kWeakest = 3e-4;  // see System::weakest

// The normal equations of the point-to-plane error at one pose, for a left-multiplied small_motion.
struct System {
  Matrix6d H = Matrix6d::Zero();
  Vector6d g = Vector6d::Zero();
  double squared_error = 0, depth_sum = 0, weight_sum = 0;
  int inliers = 0;

  void add(const Vector3d& p, const Vector3d& n, double r, double w) {
    double J[6];
    J[0] = p.y() * n.z() - p.z() * n.y();  // d(n . (w x p)) / dw = p x n
    J[1] = p.z() * n.x() - p.x() * n.z();
    J[2] = p.x() * n.y() - p.y() * n.x();
    J[3] = n.x(), J[4] = n.y(), J[5] = n.z();
    for (int i = 0; i < 6; ++i) {
      const double wJ = w * J[i];
      for (int j = 0; j <= i; ++j) H(i, j) += wJ * J[j];
      g[i] += wJ * r;
    }
    squared_error += r * r;
    depth_sum += p.z();
    weight_sum += w;
    ++inliers;
  }
  void finish() {
    for (int i = 0; i < 6; ++i) {
      for (int j = i + 1; j < 6; ++j) H(i, j) = H(j, i);
    }
  }
  // The motion that the points determine least, against a motion that all of them see in full: 0..1. Rotations are
  // measured by how far they move a point at the mean depth.
  double weakest() const {
    const double inverse_depth = inliers / depth_sum;
    Vector6d scale;
    scale << inverse_depth, inverse_depth, inverse_depth, 1, 1, 1;
    const Matrix6d scaled = scale.asDiagonal() * H * scale.asDiagonal();
    return Eigen::SelfAdjointEigenSolver<Matrix6d>(scaled, Eigen::EigenvaluesOnly).eigenvalues()[0] / weight_sum;
  }
};

// Projective association: the target's cell that the point falls on. On a slanted surface that cell is farther away
// than the surface is, so the gate is on the distance from the surface, and a wider one on that from the cell.
System linearise(const OrganizedCloud& target, std::span<const Vector3f> source, const Pose& T, double max_distance_m,
                 double robust_m) {
  System system;
  for (const Vector3f& s : source) {
    if (!(s.z() >= kMinDepth_m)) continue;
    const Vector3d p = T * s.cast<double>();
    if (!(p.z() >= kMinDepth_m)) continue;
    const double u = target.fx * p.x() / p.z() + target.cx + 0.5, v = target.fy * p.y() / p.z() + target.cy + 0.5;
    if (!(u >= 0 && v >= 0 && u < target.width && v < target.height)) continue;
    const std::size_t i =
        static_cast<std::size_t>(v) * static_cast<std::size_t>(target.width) + static_cast<std::size_t>(u);
    const Vector3d q = target.points[i].cast<double>(), n = target.normals[i].cast<double>();
    if (q.z() == 0 || n.squaredNorm() == 0) continue;
    const Vector3d d = p - q;
    const double r = n.dot(d);
    if (std::abs(r) > max_distance_m || d.squaredNorm() > 4 * max_distance_m * max_distance_m) continue;
    const double sigma = depth_sigma(q.z()), k = std::max(robust_m, kNoiseSigmas * sigma);
    const double robust = k * k / (k * k + r * r);  // Geman and McClure
    system.add(p, n, r, robust * robust / (sigma * sigma));
  }
  system.finish();
  return system;
}

}  // namespace

Icp::Icp(const IcpConfig& config) : config_(config) {}

IcpResult Icp::align(const OrganizedCloud& target, std::span<const Vector3f> source, const Pose& T0) const {
  IcpResult result;
  result.T_target_source = T0;
  double robust_m = 2 * config_.max_distance_m;  // shrinks to the noise as the clouds come together
  double last_size = 0;
  bool settled = false;
  for (;; ++result.iterations) {
    const System system = linearise(target, source, result.T_target_source, config_.max_distance_m, robust_m);
    result.inliers = system.inliers;
    result.information = system.H;
    result.gradient = system.g;
    result.error_m = system.inliers > 0 ? std::sqrt(system.squared_error / system.inliers) : 0;
    result.reason = IcpReason::too_few_inliers;
    if (system.inliers < std::max(6, config_.min_inliers)) return result;
    if (settled || result.iterations >= config_.max_iterations) {
      result.converged = settled;
      result.reason = settled ? IcpReason::converged : IcpReason::iteration_limit;
      if (system.weakest() < kWeakest) {
        result.converged = false;
        result.reason = IcpReason::degenerate;
      }
      return result;
    }
    Matrix6d H = system.H;
    H.diagonal() *= 1 + 1e-6;
    const Vector6d step = H.ldlt().solve(-system.g);
    result.T_target_source = small_motion(step) * result.T_target_source;
    const double size =
        std::max(step.head<3>().norm() / config_.stop_rotation_rad, step.tail<3>().norm() / config_.stop_translation_m);
    const bool flickers = size < kFlicker && size > 0.7 * last_size;
    settled = robust_m < kLastRobust_m && (size < 1 || flickers);
    last_size = size;
    robust_m *= kShrink;
  }
}

}  // namespace onemap::mapping
