#pragma once
#include "control/protocol.hpp"
#include "mapping/geometry.hpp"

namespace onemap::daemon {

// [x, y, z, qx, qy, qz, qw], metres, as in a line of a TUM trajectory.
inline control::Json pose_array(const mapping::Pose& pose) {
  const auto q = mapping::to_quaternion_wxyz(pose.R);
  return {pose.t.x(), pose.t.y(), pose.t.z(), q[1], q[2], q[3], q[0]};
}

}  // namespace onemap::daemon
