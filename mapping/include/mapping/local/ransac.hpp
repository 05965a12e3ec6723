#pragma once
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "mapping/geometry.hpp"

namespace onemap::mapping {

enum class RansacReason : std::uint8_t { ok, too_few_matches, degenerate, too_few_inliers };
std::string_view to_string(RansacReason reason);

struct RansacResult {
  RansacReason reason = RansacReason::too_few_matches;
  int iterations = 0;
  int inliers = 0;
  bool ok() const { return reason == RansacReason::ok; }
};

struct FundamentalConfig {
  double threshold = 1.5 / 525;  // largest Sampson distance, in the units of the points (here normalised image plane)
  int max_iterations = 200;
  double confidence = 0.995;
  int min_inliers = 15;
  std::uint64_t seed = 1;
};

// Eq. (6): x_r^T F x_s = 0. Eight-point (normalised) RANSAC over matched 2D points (undistorted, normalised image plane
// or pixels), then a re-fit on all inliers. inlier[i] is set to 1 or 0 for each match. F has rank 2 and unit Frobenius
// norm.
class FundamentalRansac {
 public:
  FundamentalRansac(const FundamentalConfig& config, std::size_t max_matches);
  RansacResult estimate(std::span<const Eigen::Vector2d> r, std::span<const Eigen::Vector2d> s,
                        std::span<std::uint8_t> inlier, Matrix3d& F);

 private:
  FundamentalConfig config_;
  std::vector<std::uint8_t> candidate_;
};

struct RigidConfig {
  double threshold_m = 0.03;  // at 1 m; grows with depth squared like a structured-light sensor's noise
  int max_iterations = 300;
  double confidence = 0.999;
  int min_inliers = 12;
  std::uint64_t seed = 1;
};

// The paper's 3D RANSAC: T_r_s from matched 3D points p_r[i] <-> p_s[i] (camera frames, metres; z is depth), by minimal
// samples of three and least squares (Horn / Umeyama) on the inliers.
class RigidRansac {
 public:
  RigidRansac(const RigidConfig& config, std::size_t max_matches);
  RansacResult estimate(std::span<const Vector3d> r, std::span<const Vector3d> s, std::span<std::uint8_t> inlier,
                        Pose& T_r_s);

 private:
  RigidConfig config_;
  std::vector<std::uint8_t> candidate_;
};

// Least-squares rigid transform r = T s over the points with use[i] != 0 (use may be empty: all). False when degenerate
// (fewer than three points, or all on one line).
bool fit_rigid(std::span<const Vector3d> r, std::span<const Vector3d> s, std::span<const std::uint8_t> use,
               Pose& T_r_s);

}  // namespace onemap::mapping
