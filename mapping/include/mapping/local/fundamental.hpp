#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "mapping/geometry.hpp"
#include "mapping/local/ransac.hpp"

namespace onemap::mapping {

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

}  // namespace onemap::mapping
