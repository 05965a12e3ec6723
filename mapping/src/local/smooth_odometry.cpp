#include "mapping/local/smooth_odometry.hpp"

namespace onemap::mapping {

void SmoothOdometry::begin_chain() {
  T_robot_camera_ = {};
  tracking_ = false;
}

void SmoothOdometry::add(const FrameReport& report) {
  const bool placed = report.state == TrackState::tracking;
  if (placed) {
    if (tracking_ && !report.relocalized) T_odom_camera_ = robot_in_odom() * report.T_robot_camera;
    T_robot_camera_ = report.T_robot_camera;
    T_odom_camera_.R = orthonormal(T_odom_camera_.R);
  }
  tracking_ = placed;
}

}  // namespace onemap::mapping
