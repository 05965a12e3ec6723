#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "hal/base/result.hpp"
#include "mapping/geometry.hpp"

namespace onemap::daemon {

// What a robot is doing, for whoever starts it: OUT/status.json, rewritten whole several times a second.
struct DaemonStatus {
  std::string state = "tracking";     // tracking, merging (own work done, team not), settled
  std::uint64_t frames = 0;           // done
  std::uint64_t frames_expected = 0;  // of the stream; 0: unknown
  std::uint64_t tracked = 0, keyframes = 0;
  // Frames that the camera gave and nobody saw: dropped to keep pace, unreadable, not fetched in time; and its images
  // without a partner in time (CaptureCounters).
  std::uint64_t frames_dropped = 0, frames_bad = 0, frames_missed = 0, images_unmatched = 0;
  std::uint64_t blocks_refused = 0;   // of the local map, for want of room
  std::uint64_t map_digest = 0;       // of the global map; 0: none yet
  std::uint64_t frontier_digest = 0;  // of the records held
  std::uint64_t robots_known = 1, robots_finished = 0, robots_in_map = 0;
  std::map<std::string, std::uint32_t> keyframes_in_map;  // of each robot's present life, in this robot's global map
  bool agreed = false;                   // every robot that is not gone is finished and reports this digest
  bool map_agreed = false;               // every robot that is not gone holds the same map, finished or not, lately
  std::vector<std::string> map_differs;  // those that do not
  // Where the camera is: smooth odometry, and the correction to the global map (ROS REP 105's odom and map; camera
  // frame: x right, y down, z forward). No correction: this robot is not in the global map.
  bool tracking = false;
  double pose_time_s = 0;  // of the frame
  mapping::Pose T_odom_camera;
  std::optional<mapping::Pose> T_map_odom;
  // Own work done, but no agreement yet: what this robot waits for, in words, and whether that cannot come by itself.
  std::string waiting;
  bool stuck = false;
  std::map<std::string, double> consensus;       // what the team agrees on (comms::Scalar), as far as it is known
  std::map<std::string, std::uint64_t> refused;  // datagrams and records, by reason
};

std::string to_json(const DaemonStatus& status);
Result<DaemonStatus> status_from_json(const std::string& text, const std::string& place);
Result<DaemonStatus> read_status(const std::string& file);
Status write_status(const std::string& file, const DaemonStatus& status);

}  // namespace onemap::daemon
