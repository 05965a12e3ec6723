#include "se3.hpp"

namespace onemap::mapping {

namespace {

Matrix3d cross(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

}  // namespace

Matrix6d adjoint(const Pose& X) {
  Matrix6d m;
  m.topLeftCorner<3, 3>() = X.R;
  m.topRightCorner<3, 3>().setZero();
  m.bottomLeftCorner<3, 3>() = cross(X.t) * X.R;
  m.bottomRightCorner<3, 3>() = X.R;
  return m;
}

Vector6d motion_error(const Pose& E) {
  const auto q = to_quaternion_wxyz(E.R);
  Vector6d e;
  e << 2 * q[1], 2 * q[2], 2 * q[3], E.t;
  return e;
}

Matrix6d motion_error_slope(const Pose& E) {
  const auto q = to_quaternion_wxyz(E.R);
  Matrix6d m = Matrix6d::Zero();
  m.topLeftCorner<3, 3>() = q[0] * Matrix3d::Identity() + cross({q[1], q[2], q[3]});
  m.bottomRightCorner<3, 3>() = E.R;
  return m;
}

}  // namespace onemap::mapping
