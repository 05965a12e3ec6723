#include "mapping/local/rigid.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "local/ransac_sampling.hpp"

namespace onemap::mapping {
namespace {

// The inlier threshold of a match: the matched pixels' error grows with depth, the sensor's noise with its square.
double threshold_m(const RigidConfig& config, double z_m) {
  constexpr double kSigmas = 3;
  const double grown = config.threshold_m * z_m + kSigmas * (config.noise.sigma_m(z_m) - config.noise.sigma_m(1.0));
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

// One problem: the matches, and the best transform so far with its inliers.
struct Search {
  const RigidConfig& config;
  std::span<const Vector3d> r, s;
  std::span<std::uint8_t> candidate, inlier;
  Pose& T_r_s;
  int best = 0;

  int least() const { return std::max(3, config.min_inliers); }
  bool all_in() const { return best == static_cast<int>(r.size()); }

  // Points nearer to the truth weigh more: 1 / threshold^2.
  bool fit(Pose& T) const {
    const auto weight = [&](std::size_t i) {
      const double limit = threshold_m(config, r[i], s[i]);
      return inlier[i] ? 1 / (limit * limit) : 0.0;
    };
    return fit_weighted(r, s, weight, T);
  }

  void accept(const Pose& T, int count) {
    best = count;
    T_r_s = T;
    std::copy(candidate.begin(), candidate.end(), inlier.begin());
  }

  bool accept_better(const Pose& T) {
    const int count = mark_inliers(config, r, s, T, r.size() - static_cast<std::size_t>(best) - 1, candidate);
    if (count <= best) return false;
    accept(T, count);
    return true;
  }

  // Samples of three until one without outliers is likely among them; whether any was a triangle at all.
  bool sample_triangles(int& iterations) {
    SplitMix random(config.seed);
    bool any = false;
    for (int needed = config.max_iterations; iterations < needed && !all_in();) {
      ++iterations;
      Pose T;
      if (!from_three(config, r, s, sample<3>(random, r.size()), T)) continue;
      any = true;
      if (!accept_better(T)) continue;
      for (int k = 0; k < 2 && !all_in() && fit(T) && accept_better(T);) ++k;
      needed = ransac_iterations(static_cast<double>(best) / static_cast<double>(r.size()), 3, config.confidence,
                                 config.max_iterations);
    }
    return any;
  }

  // The last fits: the set may lose a point at its border, the fit is better for it. False when degenerate.
  bool polish() {
    for (int k = 0; k < 3; ++k) {
      Pose T;
      if (!fit(T)) return false;
      const int count = mark_inliers(config, r, s, T, r.size(), candidate);
      if (count < least()) break;
      const bool same = std::equal(candidate.begin(), candidate.end(), inlier.begin());
      accept(T, count);
      if (same) break;
    }
    return true;
  }
};

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
  Search search{config_, r, s, {candidate_.data(), n}, inlier, T_r_s};
  if (n < static_cast<std::size_t>(search.least())) return result;
  const bool any = search.sample_triangles(result.iterations);
  result.inliers = search.best;
  result.reason = any ? RansacReason::too_few_inliers : RansacReason::degenerate;
  if (search.best < search.least()) return result;
  result.reason = search.polish() ? RansacReason::ok : RansacReason::degenerate;
  result.inliers = search.best;
  return result;
}

}  // namespace onemap::mapping
