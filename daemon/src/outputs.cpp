#include "daemon/outputs.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

namespace onemap::daemon {

namespace {

std::string time_text(FrameTime time) {
  const std::int64_t us = (time.time_since_epoch().count() + 500) / 1000;  // recordings have whole microseconds
  return fmt::format("{}.{:06}", us / 1000000, us % 1000000);
}

}  // namespace

std::string pose_line(FrameTime time, const mapping::Pose& T) {
  const auto q = mapping::to_quaternion_wxyz(T.R);
  return fmt::format("{} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f}\n", time_text(time), T.t.x(), T.t.y(),
                     T.t.z(), q[1], q[2], q[3], q[0]);
}

std::string trajectory_text(const std::vector<mapping::StampedPose>& poses, const mapping::Pose& T_frame_robot) {
  std::string text;
  for (const mapping::StampedPose& stamped : poses)
    text += pose_line(stamped.time, T_frame_robot * mapping::from_quantized(stamped.T_robot_camera));
  return text;
}

Status make_folder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return Error{folder, "cannot make the folder: " + error.message()};
  if (!std::filesystem::is_directory(folder, error)) return Error{folder, "cannot make the folder: a file is there"};
  if (::access(folder.c_str(), W_OK | X_OK) != 0)
    return Error{folder, std::string("cannot write to the folder: ") + std::strerror(errno)};
  return success();
}

}  // namespace onemap::daemon
