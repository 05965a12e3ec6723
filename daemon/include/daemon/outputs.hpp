#pragma once
#include <string>
#include <vector>

#include "hal/base/result.hpp"
#include "mapping/records/trajectory.hpp"

namespace onemap::daemon {

// A line of a trajectory in TUM's format: `time tx ty tz qx qy qz qw`, metres, time with 6 decimals printed from its
// integer nanoseconds.
std::string pose_line(FrameTime time, const mapping::Pose& T_frame_camera);
// All of them. Each pose is T_frame_robot * T_robot_camera.
std::string trajectory_text(const std::vector<mapping::StampedPose>& poses, const mapping::Pose& T_frame_robot = {});

// Makes the folder with its parents; the error names the folder. One that is there but takes no files is an error, too.
Status make_folder(const std::string& folder);

}  // namespace onemap::daemon
