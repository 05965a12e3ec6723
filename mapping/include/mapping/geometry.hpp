#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

namespace onemap::mapping {

using Vector3f = Eigen::Vector3f;  // no alignment requirement: safe in std::vector
using Vector3d = Eigen::Vector3d;
using Matrix3d = Eigen::Matrix3d;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Rgb = std::array<std::uint8_t, 3>;

// A rigid motion, the paper's T (eq. 8): p_a = T_a_b * p_b = R p_b + t, metres. T_a_b maps frame b to frame a.
struct Pose {
  Matrix3d R = Matrix3d::Identity();
  Vector3d t = Vector3d::Zero();

  Vector3d operator*(const Vector3d& p) const { return R * p + t; }
  Pose operator*(const Pose& other) const { return {R * other.R, R * other.t + t}; }
  Pose inverse() const { return {R.transpose(), -(R.transpose() * t)}; }
};

// Unit quaternion (w >= 0) of a rotation matrix, and back. Only + - * / sqrt: the same bits on every machine.
std::array<double, 4> to_quaternion_wxyz(const Matrix3d& R);
Matrix3d from_quaternion_wxyz(const std::array<double, 4>& q);

// The nearest rotation: removes the drift of repeated products.
Matrix3d orthonormal(const Matrix3d& R);

// A small motion (rotation vector w in rad, translation v in m) by the Cayley map: exact for w -> 0, a rotation for
// every w, and rational (no sin, no cos). w = 2 tan(angle/2) * axis. The increment that Gauss-Newton steps apply on the
// left.
Pose small_motion(const Vector6d& wv);
// The other way: the left motion (w, v) with small_motion(wv) * from = to, for poses less than half a turn apart.
Vector6d motion_between(const Pose& from, const Pose& to);

// The cosine of a rotation's angle: thresholds on angles are compared as cosines, without an inverse function.
inline double rotation_cosine(const Matrix3d& R) { return 0.5 * (R.trace() - 1); }

// A pose as integers, as it stands in records: translation in units of 10 micrometres, quaternion (w x y z, w >= 0)
// in units of 2^-30; farther than 21 km becomes 21 km. Converting back gives the same doubles on every machine.
struct QuantizedPose {
  std::array<std::int32_t, 3> t_10um{};
  std::array<std::int32_t, 4> q_wxyz{1 << 30, 0, 0, 0};
  auto operator<=>(const QuantizedPose&) const = default;
};
QuantizedPose quantize(const Pose& pose);
Pose from_quantized(const QuantizedPose& pose);

}  // namespace onemap::mapping
