#pragma once
#include <algorithm>
#include <cmath>

#include "mapping/geometry.hpp"
#include "mapping/local/features.hpp"

namespace onemap::mapping {

// What one feature says of where its landmark is, in pixels: the image position and, as a structured-light camera
// measures depth by a disparity over its baseline, a disparity b f / z. The Kinect family's b f is 40 (0.075 m x 525
// px); its disparity is surer than a feature's place in the image, so it counts as a longer baseline. Tried, ATE in mm
// on fr1_xyz / fr1_rpy_a / three simulated robots: 40: 10.4 / 26.1 / 6.8; 80: 10.3 / 23.3; 100: 10.2 / 22.7 / 5.0;
// 120: 10.4 / 23.3; 150: 10.6 / 22.0.
inline constexpr double kBaselineFocal_px_m = 100.0;

struct Observation {
  Eigen::Vector2d ray;       // undistorted, z = 1
  double inverse_depth = 0;  // 1/m, 0 = none
  double weight = 1;         // 1 / sigma^2 in 1/px^2
};

// The weight of a feature: the larger what it describes, the less exact its place.
inline double weight_of(const Keypoint& keypoint) {
  const double size = std::max(1.0, static_cast<double>(keypoint.size_px) / 24.0);
  return 1 / (size * size);
}

// Residual (3 rows; the third is 0 without depth) of a point in the camera's frame, in pixels.
inline Vector3d residual(const Vector3d& p_camera, const Observation& o, double focal_px) {
  const double iz = 1.0 / p_camera.z();
  return {focal_px * (p_camera.x() * iz - o.ray.x()), focal_px * (p_camera.y() * iz - o.ray.y()),
          o.inverse_depth > 0 ? kBaselineFocal_px_m * (iz - o.inverse_depth) : 0.0};
}

// d residual / d p_camera.
inline Matrix3d residual_by_point(const Vector3d& p, const Observation& o, double focal_px) {
  const double iz = 1.0 / p.z(), iz2 = iz * iz;
  Matrix3d J;
  J << focal_px * iz, 0, -focal_px * p.x() * iz2,  //
      0, focal_px * iz, -focal_px * p.y() * iz2,   //
      0, 0, o.inverse_depth > 0 ? -kBaselineFocal_px_m * iz2 : 0.0;
  return J;
}

// d p_camera / d (w, v) for a left increment of T_camera_robot: [-p]x | I.
inline Eigen::Matrix<double, 3, 6> point_by_motion(const Vector3d& p) {
  Eigen::Matrix<double, 3, 6> J;
  J << 0, p.z(), -p.y(), 1, 0, 0,  //
      -p.z(), 0, p.x(), 0, 1, 0,   //
      p.y(), -p.x(), 0, 0, 0, 1;
  return J;
}

// Chi-square bounds at 95 %: two rows (no depth) and three.
inline double chi2_bound(const Observation& o) { return o.inverse_depth > 0 ? 7.815 : 5.991; }

// Huber's weight for a squared, normalised residual.
inline double huber_weight(double chi2, double bound) { return chi2 <= bound ? 1.0 : std::sqrt(bound / chi2); }

}  // namespace onemap::mapping
