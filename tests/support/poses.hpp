#pragma once
#include <cmath>
#include <cstdint>

#include "mapping/geometry.hpp"

// Random numbers and poses for tests.
namespace onemap::test {

class SplitMix {
 public:
  explicit SplitMix(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
  }
  double uniform(double from, double to) {
    return from + (to - from) * (static_cast<double>(next() >> 11) / 9007199254740992.0);
  }
  double normal(double sigma) {  // sum of twelve uniforms
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += uniform(0, 1);
    return sigma * sum;
  }

 private:
  std::uint64_t state_;
};

inline mapping::Matrix3d rotation(const mapping::Vector3d& axis, double angle_rad) {
  return Eigen::AngleAxisd(angle_rad, axis.normalized()).toRotationMatrix();
}

// Angle of a rotation in radians, 0..pi.
inline double rotation_angle(const mapping::Matrix3d& R) {
  const auto q = mapping::to_quaternion_wxyz(R);
  return 2 * std::atan2(std::sqrt(q[1] * q[1] + q[2] * q[2] + q[3] * q[3]), q[0]);
}

// Rotation up to max_angle_rad about any axis, translation up to max_translation_m on each axis.
inline mapping::Pose random_pose(SplitMix& random, double max_angle_rad, double max_translation_m) {
  const mapping::Vector3d axis(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
  mapping::Pose pose;
  pose.R = rotation(axis, random.uniform(-max_angle_rad, max_angle_rad));
  for (int i = 0; i < 3; ++i) pose.t[i] = random.uniform(-max_translation_m, max_translation_m);
  return pose;
}

}  // namespace onemap::test
