#include "mapping/team/records.hpp"

#include <algorithm>

#include "team/field_reader.hpp"

namespace onemap::mapping {
namespace {

constexpr std::size_t kMaxCameraText = 200;
constexpr std::size_t kMaxPoses = 4096;
constexpr std::size_t kMaxRobots = 1024;
constexpr std::size_t kPoseBytes = 28;

bool printable(std::string_view text) {
  return std::none_of(text.begin(), text.end(), [](char c) { return (c >= 0 && c < 0x20) || c == 0x7F; });
}

std::string text_of(std::span<const std::uint8_t> bytes) { return {bytes.begin(), bytes.end()}; }

void put_text(ByteWriter& out, const std::string& text) {
  out.put(static_cast<std::uint8_t>(text.size()));
  for (const char c : text) out.put(static_cast<std::uint8_t>(c));
}

}  // namespace

std::vector<std::uint8_t> encode(const HelloRecord& record) {
  std::vector<std::uint8_t> body;
  ByteWriter out(body);
  put_text(out, record.name);
  put_text(out, record.camera);
  return body;
}

Result<HelloRecord> decode_hello(std::span<const std::uint8_t> body) {
  FieldReader in("hello", body);
  HelloRecord out;
  out.name = text_of(in.bytes(in.get<std::uint8_t>("name"), "name"));
  in.require(RobotId::valid_name(out.name), "name", "not 1 to 16 of A-Z a-z 0-9 _ . -");
  const std::size_t size = in.get<std::uint8_t>("camera");
  in.require(size <= kMaxCameraText, "camera", "longer than 200");
  out.camera = text_of(in.bytes(size, "camera"));
  in.require(printable(out.camera), "camera", "control characters");
  return in.finish(std::move(out));
}

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

std::vector<std::uint8_t> encode(const LinkRecord& record) {
  std::vector<std::uint8_t> body;
  ByteWriter out(body);
  put(out, record.a);
  put(out, record.b);
  out.put(record.incarnation_b);
  out.put(record.keyframes_a);
  out.put(record.keyframes_b);
  out.put(record.keyframe_a);
  out.put(record.keyframe_b);
  out.put(static_cast<std::uint8_t>(record.reason));
  out.put(record.supporting_pairs);
  out.put(record.inliers);
  out.put(record.ratio_e4);
  out.put(record.error_um);
  put(out, record.T_a_b);
  return body;
}

Result<LinkRecord> decode_link(std::span<const std::uint8_t> body) {
  FieldReader in("link", body);
  LinkRecord out;
  out.a = in.robot("a");
  out.b = in.robot("b");
  in.require(out.a < out.b, "b", "not after a");
  out.incarnation_b = in.get<std::uint64_t>("incarnation_b");
  out.keyframes_a = in.get<std::uint32_t>("keyframes_a");
  out.keyframes_b = in.get<std::uint32_t>("keyframes_b");
  out.keyframe_a = in.get<std::uint32_t>("keyframe_a");
  out.keyframe_b = in.get<std::uint32_t>("keyframe_b");
  const auto reason = in.get<std::uint8_t>("reason");
  in.require(reason <= static_cast<std::uint8_t>(LinkReason::inconsistent), "reason", "unknown");
  out.reason = static_cast<LinkReason>(reason);
  out.supporting_pairs = in.get<std::uint32_t>("supporting_pairs");
  out.inliers = in.get<std::uint32_t>("inliers");
  out.ratio_e4 = in.get<std::uint32_t>("ratio_e4");
  in.require(out.ratio_e4 <= 10000, "ratio_e4", "more than 10000");
  out.error_um = in.get<std::int32_t>("error_um");
  in.require(out.error_um >= 0, "error_um", "negative");
  out.T_a_b = in.pose("T_a_b");
  return in.finish(out);
}

std::vector<std::uint8_t> encode(const SolutionRecord& record) {
  std::vector<std::uint8_t> body;
  ByteWriter out(body);
  put(out, record.reference);
  out.put(static_cast<std::uint16_t>(record.robots.size()));
  for (const SolvedRobot& solved : record.robots) {
    put(out, solved.robot);
    put(out, solved.T_global_robot);
  }
  out.put(record.links_used);
  return body;
}

Result<SolutionRecord> decode_solution(std::span<const std::uint8_t> body) {
  FieldReader in("solution", body);
  SolutionRecord out;
  out.reference = in.robot("reference");
  const std::size_t n = in.count<std::uint16_t>(kMaxRobots, 16 + kPoseBytes, "robots");
  out.robots.resize(n);
  bool has_reference = false;
  for (std::size_t i = 0; i < n; ++i) {
    out.robots[i].robot = in.robot("robots.robot");
    out.robots[i].T_global_robot = in.pose("robots.T_global_robot");
    in.require(i == 0 || out.robots[i - 1].robot < out.robots[i].robot, "robots.robot", "not sorted");
    has_reference = has_reference || out.robots[i].robot == out.reference;
  }
  in.require(has_reference, "reference", "not among the robots");
  out.links_used = in.get<std::uint32_t>("links_used");
  return in.finish(std::move(out));
}

std::vector<std::uint8_t> encode(const FinishedRecord& record) {
  std::vector<std::uint8_t> body;
  ByteWriter out(body);
  for (const std::uint32_t n : {record.frames, record.tracked, record.keyframes, record.submaps}) out.put(n);
  return body;
}

Result<FinishedRecord> decode_finished(std::span<const std::uint8_t> body) {
  FieldReader in("finished", body);
  FinishedRecord out;
  out.frames = in.get<std::uint32_t>("frames");
  out.tracked = in.get<std::uint32_t>("tracked");
  out.keyframes = in.get<std::uint32_t>("keyframes");
  out.submaps = in.get<std::uint32_t>("submaps");
  in.require(out.tracked <= out.frames, "tracked", "more than frames");
  return in.finish(out);
}

}  // namespace onemap::mapping
