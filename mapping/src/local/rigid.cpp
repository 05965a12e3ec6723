#include "mapping/local/rigid.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "local/ransac_sampling.hpp"
#include "local/sensor_noise.hpp"

namespace onemap::mapping {
namespace {

// The inlier threshold of a match: the matched pixels' error grows with depth, the sensor's noise with its square.
double threshold_m(const RigidConfig& config, double z_m) {
  constexpr double kSigmas = 3;
  const double grown = config.threshold_m * z_m + kSigmas * (depth_sigma(z_m) - depth_sigma(1.0));
  return std::max(0.5 * config.threshold_m, grown);
}

double threshold_m(const RigidConfig& config, const Vector3d& r, const Vector3d& s) {
  return threshold_m(config, std::max(r.z(), s.z()));
}

// Weighted least squares by Horn's quaternion method; weight(i) == 0 leaves a point out.
template <class Weight>
bool fit_weighted(std::span<const Vector3d> r, std::span<const Vector3d> s, const Weight& weight, Pose& T_r_s) {
  double sum = 0;
  Vector3d mean_r = Vector3d::Zero(), mean_s = Vector3d::Zero();
  int n = 0;
  for (std::size_t i = 0; i < r.size(); ++i) {
    const double w = weight(i);
    if (w == 0) continue;
    sum += w;
    mean_r += w * r[i];
    mean_s += w * s[i];
    ++n;
  }
  if (n < 3) return false;
  mean_r /= sum;
  mean_s /= sum;
  Matrix3d M = Matrix3d::Zero(), spread = Matrix3d::Zero();  // sum of s r^T, of s s^T
  for (std::size_t i = 0; i < r.size(); ++i) {
    const double w = weight(i);
    if (w == 0) continue;
    const Vector3d a = s[i] - mean_s;
    M.noalias() += (w * a) * (r[i] - mean_r).transpose();
    spread.noalias() += (w * a) * a.transpose();
  }
  const Vector3d extent = Eigen::SelfAdjointEigenSolver<Matrix3d>(spread, Eigen::EigenvaluesOnly).eigenvalues();
  if (!(extent[1] > 1e-6 * extent[2]) || !(extent[1] > 1e-12 * sum)) return false;  // a point or a line

  Eigen::Matrix4d N;
  N << M(0, 0) + M(1, 1) + M(2, 2), M(1, 2) - M(2, 1), M(2, 0) - M(0, 2), M(0, 1) - M(1, 0),  //
      M(1, 2) - M(2, 1), M(0, 0) - M(1, 1) - M(2, 2), M(0, 1) + M(1, 0), M(2, 0) + M(0, 2),   //
      M(2, 0) - M(0, 2), M(0, 1) + M(1, 0), -M(0, 0) + M(1, 1) - M(2, 2), M(1, 2) + M(2, 1),  //
      M(0, 1) - M(1, 0), M(2, 0) + M(0, 2), M(1, 2) + M(2, 1), -M(0, 0) - M(1, 1) + M(2, 2);
  const Eigen::Vector4d q = Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(N).eigenvectors().col(3);
  T_r_s.R = from_quaternion_wxyz({q[0], q[1], q[2], q[3]});
  T_r_s.t = mean_r - T_r_s.R * mean_s;
  return true;
}

// An orthonormal frame on a triangle; false when it is (nearly) a line.
bool triangle_frame(const Vector3d& a, const Vector3d& b, const Vector3d& c, Matrix3d& frame) {
  const Vector3d x = b - a;
  const Vector3d z = x.cross(c - a);
  const double xx = x.squaredNorm(), zz = z.squaredNorm();
  if (!(zz > 0.01 * xx * (c - a).squaredNorm()) || !(zz > 1e-8)) return false;  // sine of 0.1; 1 cm by 1 cm
  frame.col(0) = x / std::sqrt(xx);
  frame.col(2) = z / std::sqrt(zz);
  frame.col(1) = frame.col(2).cross(frame.col(0));
  return true;
}

// A transform from three matches whose sides have equal lengths within the thresholds: exact for exact points.
bool from_three(const RigidConfig& config, std::span<const Vector3d> r, std::span<const Vector3d> s,
                const std::array<std::size_t, 3>& pick, Pose& T_r_s) {
  const auto [a, b, c] = pick;
  const auto same_side = [&](std::size_t i, std::size_t j) {
    const double tolerance = threshold_m(config, r[i], s[i]) + threshold_m(config, r[j], s[j]);
    return std::abs((r[i] - r[j]).norm() - (s[i] - s[j]).norm()) <= tolerance;
  };
  if (!same_side(a, b) || !same_side(b, c) || !same_side(a, c)) return false;
  Matrix3d frame_r, frame_s;
  if (!triangle_frame(r[a], r[b], r[c], frame_r) || !triangle_frame(s[a], s[b], s[c], frame_s)) return false;
  T_r_s.R.noalias() = frame_r * frame_s.transpose();
  T_r_s.t = (r[a] + r[b] + r[c]) / 3 - T_r_s.R * ((s[a] + s[b] + s[c]) / 3);
  return true;
}

// Marks the inliers of T_r_s; gives up (returns 0) as soon as more than at_most points are out.
int mark_inliers(const RigidConfig& config, std::span<const Vector3d> r, std::span<const Vector3d> s, const Pose& T_r_s,
                 std::size_t at_most_out, std::span<std::uint8_t> inlier) {
  std::size_t out = 0;
  for (std::size_t i = 0; i < r.size(); ++i) {
    const double limit = threshold_m(config, r[i], s[i]);
    const bool in = (r[i] - T_r_s * s[i]).squaredNorm() <= limit * limit;
    inlier[i] = in ? 1 : 0;
    out += in ? 0 : 1;
    if (out > at_most_out) return 0;
  }
  return static_cast<int>(r.size() - out);
}

}  // namespace

bool fit_rigid(std::span<const Vector3d> r, std::span<const Vector3d> s, std::span<const std::uint8_t> use,
               Pose& T_r_s) {
  return fit_weighted(
      r, s, [&](std::size_t i) { return use.empty() || use[i] ? 1.0 : 0.0; }, T_r_s);
}

RigidRansac::RigidRansac(const RigidConfig& config, std::size_t max_matches)
    : config_(config), candidate_(max_matches) {}

RansacResult RigidRansac::estimate(std::span<const Vector3d> r, std::span<const Vector3d> s,
                                   std::span<std::uint8_t> inlier, Pose& T_r_s) {
  assert(r.size() == s.size() && inlier.size() >= r.size() && r.size() <= candidate_.size());
  const std::size_t n = r.size();
  RansacResult result;
  inlier = inlier.first(n);
  std::fill(inlier.begin(), inlier.end(), std::uint8_t{0});
  if (n < static_cast<std::size_t>(std::max(3, config_.min_inliers))) return result;

  // Points nearer to the truth weigh more: 1 / threshold^2.
  const auto fit = [&](std::span<const std::uint8_t> use, Pose& T) {
    return fit_weighted(
        r, s,
        [&](std::size_t i) {
          const double limit = threshold_m(config_, r[i], s[i]);
          return use[i] ? 1 / (limit * limit) : 0.0;
        },
        T);
  };
  const std::span<std::uint8_t> candidate(candidate_.data(), n);
  int best = 0;
  const auto accept_better = [&](const Pose& T) {
    const int count = mark_inliers(config_, r, s, T, n - static_cast<std::size_t>(best) - 1, candidate);
    if (count <= best) return false;
    best = count;
    T_r_s = T;
    std::copy(candidate.begin(), candidate.end(), inlier.begin());
    return true;
  };

  SplitMix random(config_.seed);
  int needed = config_.max_iterations;
  bool any_hypothesis = false;
  while (result.iterations < needed && best < static_cast<int>(n)) {
    ++result.iterations;
    Pose T;
    if (!from_three(config_, r, s, sample<3>(random, n), T)) continue;
    any_hypothesis = true;
    if (!accept_better(T)) continue;
    for (int k = 0; k < 2 && best < static_cast<int>(n) && fit(inlier, T) && accept_better(T);) ++k;
    needed = ransac_iterations(static_cast<double>(best) / static_cast<double>(n), 3, config_.confidence,
                               config_.max_iterations);
  }
  result.inliers = best;
  result.reason = !any_hypothesis ? RansacReason::degenerate : RansacReason::too_few_inliers;
  if (best < std::max(3, config_.min_inliers)) return result;

  // The last fits: the set may lose a point at its border, the fit is better for it.
  for (int k = 0; k < 3; ++k) {
    Pose T;
    if (!fit(inlier, T)) {
      result.reason = RansacReason::degenerate;
      return result;
    }
    const int count = mark_inliers(config_, r, s, T, n, candidate);
    if (count < std::max(3, config_.min_inliers)) break;
    const bool same = std::equal(candidate.begin(), candidate.end(), inlier.begin());
    T_r_s = T;
    std::copy(candidate.begin(), candidate.end(), inlier.begin());
    result.inliers = count;
    if (same) break;
  }
  result.reason = RansacReason::ok;
  return result;
}

}  // namespace onemap::mapping
