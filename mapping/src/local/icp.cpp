#include "mapping/local/icp.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "mapping/local/depth_range.hpp"

namespace onemap::mapping {

namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

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

// Walks from cell (u, v) to one that is nearer to p, in ever smaller strides: about the nearest point, where the first
// guess is so far off that the projection falls on another surface.
void walk_to_nearest(const OrganizedCloud& target, const Vector3f& p, int& u, int& v) {
  const auto distance2 = [&](int ui, int vi) {
    if (ui < 0 || vi < 0 || ui >= target.width || vi >= target.height) return std::numeric_limits<float>::max();
    const Vector3f& q = target.points[target.index(ui, vi)];
    return q.z() == 0 ? std::numeric_limits<float>::max() : (q - p).squaredNorm();
  };
  constexpr std::array<std::array<int, 2>, 4> kDirections{{{0, -1}, {-1, 0}, {1, 0}, {0, 1}}};
  float best = distance2(u, v);
  for (int stride = std::max(1, target.width / 20); stride >= 1; stride /= 2) {
    const int u0 = u, v0 = v;
    for (const auto& [du, dv] : kDirections) {
      const float d = distance2(u0 + stride * du, v0 + stride * dv);
      if (d < best) best = d, u = u0 + stride * du, v = v0 + stride * dv;
    }
  }
}

// Projective association: the target's cell that the point falls on. On a slanted surface that cell is farther away
// than the surface is, so the gate is on the distance from the surface, and a wider one on that from the cell.
System linearise(const OrganizedCloud& target, std::span<const Vector3f> source, const Pose& T, const IcpConfig& config,
                 double robust_m) {
  const double max_cell_m = config.cell_gate * config.max_distance_m;
  System system;
  for (const Vector3f& s : source) {
    if (!(s.z() >= kMinDepth_m)) continue;
    const Vector3d p = T * s.cast<double>();
    if (!(p.z() >= kMinDepth_m)) continue;
    const double u_px = target.fx * p.x() / p.z() + target.cx + 0.5, v_px = target.fy * p.y() / p.z() + target.cy + 0.5;
    if (!(u_px >= 0 && v_px >= 0 && u_px < target.width && v_px < target.height)) continue;
    int u = static_cast<int>(u_px), v = static_cast<int>(v_px);
    if (robust_m > config.search_robust_m) walk_to_nearest(target, p.cast<float>(), u, v);
    const auto i = target.index(u, v);
    const Vector3d q = target.points[i].cast<double>(), n = target.normals[i].cast<double>();
    if (q.z() == 0 || n.squaredNorm() == 0) continue;
    const Vector3d d = p - q;
    const double r = n.dot(d);
    if (std::abs(r) > config.max_distance_m || d.squaredNorm() > max_cell_m * max_cell_m) continue;
    const double sigma = target.noise.sigma_m(q.z()), k = std::max(robust_m, config.noise_sigmas * sigma);
    const double robust = k * k / (k * k + r * r);  // Geman and McClure
    system.add(p, n, r, robust * robust / (sigma * sigma));
  }
  system.finish();
  return system;
}

// Solves a Gauss-Newton step. The damping only keeps directions that nothing determines where they are.
Vector6d solve(const System& system, const Matrix6d* hold, const Pose& T0, const Pose& T) {
  Matrix6d H = system.H;
  Vector6d g = system.g;
  H.diagonal() *= 1 + 1e-6;
  if (hold != nullptr) {
    H += *hold;
    g += *hold * motion_between(T0, T);
  }
  return H.ldlt().solve(-g);
}

// The robust scale is wide at first, lingers while the clouds still move, and drops when they rest at it.
double next_robust(const IcpConfig& config, double robust_m, const Vector6d& step, double depth_m) {
  const double motion_m = depth_m * step.head<3>().norm() + step.tail<3>().norm();
  return robust_m * (motion_m < config.rest * robust_m ? config.drop : config.linger);
}

}  // namespace

Icp::Icp(const IcpConfig& config) : config_(config) {}

IcpResult Icp::align(const OrganizedCloud& target, std::span<const Vector3f> source, const Pose& T0,
                     const Matrix6d* hold) const {
  IcpResult result;
  result.T_target_source = T0;
  double robust_m = config_.first_robust * config_.max_distance_m;
  double last_size = 0;
  bool settled = false;
  for (;; ++result.iterations) {
    const System system = linearise(target, source, result.T_target_source, config_, robust_m);
    result.inliers = system.inliers;
    result.information = system.H;
    result.gradient = system.g;
    result.weight = system.weight_sum;
    result.error_m = system.inliers > 0 ? std::sqrt(system.squared_error / system.inliers) : 0;
    result.reason = IcpReason::too_few_inliers;
    if (system.inliers < std::max(6, config_.min_inliers)) return result;
    if (settled || result.iterations >= config_.max_iterations) {
      result.reason = system.weakest() < config_.weakest_direction ? IcpReason::degenerate
                      : settled                                    ? IcpReason::converged
                                                                   : IcpReason::iteration_limit;
      result.converged = result.reason == IcpReason::converged;
      return result;
    }
    const Vector6d step = solve(system, hold, T0, result.T_target_source);
    result.T_target_source = small_motion(step) * result.T_target_source;
    const double size =
        std::max(step.head<3>().norm() / config_.stop_rotation_rad, step.tail<3>().norm() / config_.stop_translation_m);
    const bool flickers = size < config_.flicker && size > config_.flicker_shrink * last_size;
    settled = robust_m < config_.last_robust_m && (size < 1 || flickers);
    last_size = size;
    robust_m = next_robust(config_, robust_m, step, system.depth_sum / system.inliers);
  }
}

}  // namespace onemap::mapping
