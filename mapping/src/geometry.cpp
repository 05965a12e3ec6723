#include "mapping/geometry.hpp"

#include <cmath>

namespace onemap::mapping {

std::array<double, 4> to_quaternion_wxyz(const Matrix3d& R) {
  // Shepperd's method: the largest of the four components first, so that no division is by a small number.
  const double trace = R(0, 0) + R(1, 1) + R(2, 2);
  std::array<double, 4> q{};
  if (trace > 0) {
    const double s = std::sqrt(trace + 1.0) * 2;
    q = {0.25 * s, (R(2, 1) - R(1, 2)) / s, (R(0, 2) - R(2, 0)) / s, (R(1, 0) - R(0, 1)) / s};
  } else if (R(0, 0) > R(1, 1) && R(0, 0) > R(2, 2)) {
    const double s = std::sqrt(1.0 + R(0, 0) - R(1, 1) - R(2, 2)) * 2;
    q = {(R(2, 1) - R(1, 2)) / s, 0.25 * s, (R(0, 1) + R(1, 0)) / s, (R(0, 2) + R(2, 0)) / s};
  } else if (R(1, 1) > R(2, 2)) {
    const double s = std::sqrt(1.0 + R(1, 1) - R(0, 0) - R(2, 2)) * 2;
    q = {(R(0, 2) - R(2, 0)) / s, (R(0, 1) + R(1, 0)) / s, 0.25 * s, (R(1, 2) + R(2, 1)) / s};
  } else {
    const double s = std::sqrt(1.0 + R(2, 2) - R(0, 0) - R(1, 1)) * 2;
    q = {(R(1, 0) - R(0, 1)) / s, (R(0, 2) + R(2, 0)) / s, (R(1, 2) + R(2, 1)) / s, 0.25 * s};
  }
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  const double sign = q[0] < 0 ? -1 : 1;
  for (double& c : q) c = sign * c / norm;
  return q;
}

Matrix3d from_quaternion_wxyz(const std::array<double, 4>& q) {
  const double n = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  const double w = q[0] / n, x = q[1] / n, y = q[2] / n, z = q[3] / n;
  Matrix3d R;
  R << 1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),  //
      2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),   //
      2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y);
  return R;
}

Matrix3d orthonormal(const Matrix3d& R) { return from_quaternion_wxyz(to_quaternion_wxyz(R)); }

Pose small_motion(const Vector6d& wv) {
  // The quaternion (1, w/2) normalised is the rotation by 2 atan(|w|/2) about w.
  return {from_quaternion_wxyz({1.0, 0.5 * wv[0], 0.5 * wv[1], 0.5 * wv[2]}), Vector3d(wv[3], wv[4], wv[5])};
}

Vector6d motion_between(const Pose& from, const Pose& to) {
  const Pose d = to * from.inverse();
  const auto q = to_quaternion_wxyz(d.R);
  Vector6d wv;
  wv << 2 * q[1] / q[0], 2 * q[2] / q[0], 2 * q[3] / q[0], d.t;
  return wv;
}

namespace {
// What does not fit is the farthest that does: records from outside may place a robot anywhere.
std::int32_t rounded(double v) {
  constexpr double kMost = 2147483647.0;
  if (!(v > -kMost)) return -2147483647;
  return v >= kMost ? 2147483647 : static_cast<std::int32_t>(v < 0 ? v - 0.5 : v + 0.5);
}
constexpr double kTranslationUnit_m = 1e-5;
constexpr double kQuaternionOne = 1 << 30;
}  // namespace

QuantizedPose quantize(const Pose& pose) {
  QuantizedPose out;
  for (int i = 0; i < 3; ++i) out.t_10um[static_cast<std::size_t>(i)] = rounded(pose.t[i] / kTranslationUnit_m);
  const auto q = to_quaternion_wxyz(pose.R);
  for (std::size_t i = 0; i < 4; ++i) out.q_wxyz[i] = rounded(q[i] * kQuaternionOne);
  return out;
}

Pose from_quantized(const QuantizedPose& pose) {
  Pose out;
  for (int i = 0; i < 3; ++i) out.t[i] = pose.t_10um[static_cast<std::size_t>(i)] * kTranslationUnit_m;
  std::array<double, 4> q{};
  for (std::size_t i = 0; i < 4; ++i) q[i] = pose.q_wxyz[i] / kQuaternionOne;
  if (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] > 0) out.R = from_quaternion_wxyz(q);
  return out;
}

}  // namespace onemap::mapping
