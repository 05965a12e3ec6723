#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "hal/depth_noise.hpp"
#include "mapping/geometry.hpp"
#include "mapping/local/ransac.hpp"

namespace onemap::mapping {

struct RigidConfig {
  double threshold_m = 0.03;  // at 1 m; grows with depth as the noise does
  int max_iterations = 300;
  double confidence = 0.999;
  int min_inliers = 12;
  std::uint64_t seed = 1;
  hal::DepthNoise noise;
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
