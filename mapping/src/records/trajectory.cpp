#include "mapping/records/trajectory.hpp"

#include "records/field_reader.hpp"

namespace onemap::mapping {
namespace {

constexpr std::size_t kMaxPoses = 4096;

}  // namespace

std::vector<std::uint8_t> encode(const TrajectoryRecord& record) {
  std::vector<std::uint8_t> body;
  body.reserve(2 + record.poses.size() * (8 + kPoseBytes));
  ByteWriter out(body);
  out.put(static_cast<std::uint16_t>(record.poses.size()));
  for (const StampedPose& pose : record.poses) {
    put(out, pose.time);
    put(out, pose.T_robot_camera);
  }
  return body;
}

Result<TrajectoryRecord> decode_trajectory(std::span<const std::uint8_t> body) {
  FieldReader in("trajectory", body);
  TrajectoryRecord out;
  const std::size_t n = in.count<std::uint16_t>(kMaxPoses, 8 + kPoseBytes, "poses");
  out.poses.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    out.poses[i].time = in.time("poses.time");
    out.poses[i].T_robot_camera = in.pose("poses.T_robot_camera");
    in.require(i == 0 || out.poses[i - 1].time < out.poses[i].time, "poses.time", "not increasing");
  }
  return in.finish(std::move(out));
}

}  // namespace onemap::mapping
