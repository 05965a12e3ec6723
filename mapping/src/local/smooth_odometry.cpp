#include "mapping/local/smooth_odometry.hpp"

namespace onemap::mapping {

void SmoothOdometry::begin_chain() {
  T_robot_camera_ = {};
  tracking_ = false;
}

void SmoothOdometry::add(const FrameReport& report) {
  if (report.reason == TrackReason::time_not_increasing) return;  // as if it had not been
  if (report.placed()) {
    if (tracking_ && !report.relocalized) T_odom_camera_ = robot_in_odom() * report.T_robot_camera;
    T_robot_camera_ = report.T_robot_camera;
    T_odom_camera_.R = orthonormal(T_odom_camera_.R);
  }
  tracking_ = report.placed();
}

}  // namespace onemap::mapping
