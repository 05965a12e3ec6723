#pragma once
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "mapping/local/point_cloud.hpp"

namespace onemap::mapping {

struct IcpConfig {
  float max_distance_m = 0.10f;    // points farther from the target's surface are not used
  float min_normal_cosine = 0.0f;  // reserved for clouds that carry normals on both sides
  int max_iterations = 30;
  double stop_rotation_rad = 1e-4;  // converged when a step is smaller than both
  double stop_translation_m = 1e-4;
  int min_inliers = 100;
};

enum class IcpReason : std::uint8_t { converged, iteration_limit, too_few_inliers, degenerate };
std::string_view to_string(IcpReason reason);

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
};

// Iterative closest point (Besl and McKay; the paper, figure 6): projective association into an organised target,
// point-to-plane error with a robust weight that follows the sensor's depth noise, Gauss-Newton. No allocation.
// Deterministic.
class Icp {
 public:
  explicit Icp(const IcpConfig& config);
  // source: points in the source camera's frame (downsampled); T0: first guess of T_target_source.
  IcpResult align(const OrganizedCloud& target, std::span<const Vector3f> source, const Pose& T0) const;

 private:
  IcpConfig config_;
};

}  // namespace onemap::mapping
