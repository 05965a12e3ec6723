#pragma once
#include <cmath>
#include <optional>

#include "hal/base/time.hpp"
#include "mapping/geometry.hpp"

namespace onemap::mapping {

// Where the camera should be, if it goes on as it did: the last pose, and the velocity, smoothed over a tenth of a
// second. It is what is left to go by where neither colour nor depth says anything.
class Motion {
 public:
  // The two images of a frame are of two instants, and of one camera.
  static bool matters(FrameTime depth, FrameTime colour) {
    const double apart_s = to_seconds(colour - depth);
    return apart_s != 0 && std::abs(apart_s) <= 0.1;
  }
  struct Expected {
    Pose T_camera_robot;
    Eigen::Matrix<double, 6, 6> information;  // of a left increment: how much a hand may change its mind since
  };
  void start(const Vector6d& velocity);  // before the first pose
  void follow(FrameTime time, const Pose& T_camera_robot);
  // None when nothing is known, or what is known is older than 0.3 s.
  std::optional<Expected> at(FrameTime time) const;
  // How the camera moves from the one instant to the other, both about now: T_to_from. Nothing: they are one, or it is
  // not known, or that does not matter. By the smoothed velocity: what depth says depends on it, and it on what depth
  // says.
  std::optional<Pose> between(FrameTime from, FrameTime to) const;

 private:
  bool any_ = false, moving_ = false;  // a pose, a velocity is known
  FrameTime time_{};
  Pose T_camera_robot_;
  Vector6d velocity_ = Vector6d::Zero();  // left increment a second
};

}  // namespace onemap::mapping
