#pragma once
#include <cmath>
#include <cstdint>

#include "mapping/geometry.hpp"
#include "support/random.hpp"

// Poses for tests.
namespace onemap::test {

inline mapping::Matrix3d rotation(const mapping::Vector3d& axis, double angle_rad) {
  return Eigen::AngleAxisd(angle_rad, axis.normalized()).toRotationMatrix();
}

// Angle of a rotation in radians, 0..pi.
inline double rotation_angle(const mapping::Matrix3d& R) {
  const auto q = mapping::to_quaternion_wxyz(R);
  return 2 * std::atan2(std::sqrt(q[1] * q[1] + q[2] * q[2] + q[3] * q[3]), q[0]);
}

// Rotation up to max_angle_rad about any axis, translation up to max_translation_m on each axis.
inline mapping::Pose random_pose(Random& random, double max_angle_rad, double max_translation_m) {
  const mapping::Vector3d axis(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
  mapping::Pose pose;
  pose.R = rotation(axis, random.uniform(-max_angle_rad, max_angle_rad));
  for (int i = 0; i < 3; ++i) pose.t[i] = random.uniform(-max_translation_m, max_translation_m);
  return pose;
}

}  // namespace onemap::test
