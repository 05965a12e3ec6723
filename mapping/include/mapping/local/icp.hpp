#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "mapping/local/organized_cloud.hpp"

namespace onemap::mapping {

struct IcpConfig {
  float max_distance_m = 0.10f;  // points farther from the target's surface are not used
  double cell_gate = 2;          // nor those farther than so many max_distance_m from the cell that they fall on
  int max_iterations = 30;
  int min_inliers = 100;

  // Converged when a step is smaller than both; or when steps that are less than `flicker` times as large shrink by
  // less than to `flicker_shrink`: then points flip between two cells.
  double stop_rotation_rad = 1e-4;
  double stop_translation_m = 1e-4;
  double flicker = 10;
  double flicker_shrink = 0.7;

  // The robust scale (Geman and McClure). It begins at first_robust times max_distance_m; while the clouds still move
  // each step takes it to `linger` of it, and to `drop` once a step moves them less than `rest` of it. It never falls
  // below noise_sigmas of the sensor's noise, which rules below last_robust_m.
  double first_robust = 2;
  double linger = 0.8;
  double drop = 0.35;
  double rest = 0.1;
  double noise_sigmas = 3;
  double last_robust_m = 0.003;
  double search_robust_m = 0.05;  // above it a point looks for its nearest cell, below it takes its own

  // Degenerate when the points determine some motion less than this share of one that all of them see in full, 0..1.
  double weakest_direction = 3e-4;
};

enum class IcpReason : std::uint8_t { converged, iteration_limit, too_few_inliers, degenerate };

struct IcpResult {
  Pose T_target_source;
  bool converged = false;
  int iterations = 0;
  int inliers = 0;
  double error_m = 0;  // root mean square point-to-plane distance of the inliers
  IcpReason reason = IcpReason::too_few_inliers;
  Eigen::Matrix<double, 6, 6> information =
      Eigen::Matrix<double, 6, 6>::Zero();  // J^T W J (rotation, translation) at the result
  Vector6d gradient = Vector6d::Zero();     // J^T W r at the result
  double weight = 0;                        // the sum of W: what a motion that all inliers see in full would have
};

// Iterative closest point (Besl and McKay; the paper, figure 6): projective association into an organised target,
// point-to-plane error, each weighed by 1 / sigma^2 of the target's camera at its depth and by a robust weight that
// follows sigma, too; Gauss-Newton. No allocation.
// Deterministic.
class Icp {
 public:
  explicit Icp(const IcpConfig& config);
  // source: points in the source camera's frame (downsampled); T0: first guess of T_target_source.
  // hold: the information by which the result is drawn to T0, of a left increment of T_target_source; what the points
  // do not say stays as it was then. The result's information and gradient are those of the points alone.
  IcpResult align(const OrganizedCloud& target, std::span<const Vector3f> source, const Pose& T0,
                  const Eigen::Matrix<double, 6, 6>* hold = nullptr) const;

 private:
  IcpConfig config_;
};

}  // namespace onemap::mapping
