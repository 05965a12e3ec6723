#include "motion.hpp"

#include <cmath>

namespace onemap::mapping {

namespace {

constexpr double kLongest_s = 0.3;
constexpr double kSmoothing_s = 0.1;
constexpr double kUnrest_m = 0.3, kUnrest_rad = 0.5;  // by which the expected place is wrong, a second

}  // namespace

void Motion::start(const Vector6d& velocity) {
  velocity_ = velocity;
  moving_ = true;
}

void Motion::follow(FrameTime time, const Pose& T_camera_robot) {
  const double passed_s = any_ ? to_seconds(time - time_) : 0;
  if (passed_s > 0 && passed_s <= kLongest_s) {
    const Vector6d now = motion_between(T_camera_robot_, T_camera_robot) / passed_s;
    velocity_ += (moving_ ? passed_s / (passed_s + kSmoothing_s) : 1) * (now - velocity_);
    moving_ = true;
  } else if (any_) {
    velocity_.setZero();
    moving_ = false;
  }
  any_ = true;
  time_ = time;
  T_camera_robot_ = T_camera_robot;
}

std::optional<Motion::Expected> Motion::at(FrameTime time) const {
  const double passed_s = any_ ? to_seconds(time - time_) : 0;
  if (!(passed_s > 0 && passed_s <= kLongest_s)) return std::nullopt;
  Expected out;
  out.T_camera_robot = small_motion(passed_s * velocity_) * T_camera_robot_;
  const double rad = kUnrest_rad * passed_s, m = kUnrest_m * passed_s;
  Vector6d information;
  information << Vector3d::Constant(1 / (rad * rad)), Vector3d::Constant(1 / (m * m));
  out.information = information.asDiagonal();
  return out;
}

std::optional<Pose> Motion::between(FrameTime from, FrameTime to) const {
  const double passed_s = any_ ? std::abs(to_seconds(to - time_)) : 0;
  if (!matters(from, to) || !moving_ || !(passed_s <= kLongest_s)) return std::nullopt;
  return small_motion(to_seconds(to - from) * velocity_);
}

}  // namespace onemap::mapping
