#pragma once
#include <optional>
#include <string>
#include <vector>

#include "daemon/mcap/mcap_writer.hpp"
#include "hal/frame.hpp"
#include "mapping/geometry.hpp"

namespace onemap::daemon {

// Where the camera was at a frame: in its smooth odometry, and from there to the map, when that is known.
struct RecordedPose {
  FrameTime time{};
  mapping::Pose T_odom_camera;
  std::optional<mapping::Pose> T_map_odom;
};

// A recording to look at in Foxglove: /camera/image (JPEG) of each frame, /camera/points of every tenth, /pose/odom and
// /pose/map, and the transforms between map, odom and camera on /tf. Used by one thread.
class McapRecording {
 public:
  static Result<McapRecording> create(const std::string& path);
  Status write(const hal::FrameView& frame);
  Status write(const RecordedPose& pose);
  Status finish() { return writer_.finish(); }
  std::uint64_t bytes() const { return writer_.bytes(); }

 private:
  explicit McapRecording(McapWriter writer);
  McapWriter writer_;
  std::uint16_t image_, points_, tf_, odom_, map_;
  std::uint64_t frames_ = 0;
  std::vector<std::uint8_t> file_;
};

}  // namespace onemap::daemon
