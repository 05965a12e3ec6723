#pragma once
#include "mapping/geometry.hpp"
#include "mapping/local/local_mapper.hpp"

namespace onemap::mapping {

// The way of the camera as the sum of its steps: it drifts and never jumps (the frame `odom` of ROS REP 105). The
// mapper's own estimate does when the camera is placed again after it was lost; here the way then goes on from where it
// was, and the difference is the correction's.
class SmoothOdometry {
 public:
  void add(const FrameReport& report);
  void begin_chain();  // the next frame's frame is another one

  const Pose& camera_in_odom() const { return T_odom_camera_; }
  Pose robot_in_odom() const { return T_odom_camera_ * T_robot_camera_.inverse(); }  // the identity until a jump

 private:
  Pose T_odom_camera_, T_robot_camera_;
  bool tracking_ = false;  // the last frame was placed
};

}  // namespace onemap::mapping
