#include "daemon/status.hpp"

#include <charconv>
#include <nlohmann/json.hpp>

#include "daemon/report.hpp"
#include "hal/base/file.hpp"
#include "hal/base/text.hpp"

namespace onemap::daemon {

using Json = nlohmann::ordered_json;

namespace {
std::uint64_t digest_from(const Json& value) {
  const auto text = value.get<std::string>();
  std::uint64_t digest = 0;
  std::from_chars(text.data(), text.data() + text.size(), digest, 16);
  return digest;
}
// [x, y, z, qx, qy, qz, qw], metres, as in a line of a TUM trajectory.
Json pose_json(const mapping::Pose& pose) {
  const auto q = mapping::to_quaternion_wxyz(pose.R);
  return {pose.t.x(), pose.t.y(), pose.t.z(), q[1], q[2], q[3], q[0]};
}

mapping::Pose pose_from(const Json& value) {
  const auto v = value.get<std::array<double, 7>>();
  return {mapping::from_quaternion_wxyz({v[6], v[3], v[4], v[5]}), {v[0], v[1], v[2]}};
}

void read_pose(const Json& object, DaemonStatus& s) {
  const Json& pose = object.at("pose");
  pose.at("tracking").get_to(s.tracking);
  pose.at("time_s").get_to(s.pose_time_s);
  s.T_odom_camera = pose_from(pose.at("T_odom_camera"));
  if (const Json& correction = pose.at("T_map_odom"); !correction.is_null()) s.T_map_odom = pose_from(correction);
}
}  // namespace

std::string to_json(const DaemonStatus& s) {
  const Json pose{{"tracking", s.tracking},
                  {"time_s", s.pose_time_s},
                  {"T_odom_camera", pose_json(s.T_odom_camera)},
                  {"T_map_odom", s.T_map_odom ? pose_json(*s.T_map_odom) : Json()}};
  const Json object{{"state", s.state},
                    {"frames", s.frames},
                    {"frames_expected", s.frames_expected},
                    {"tracked", s.tracked},
                    {"keyframes", s.keyframes},
                    {"frames_dropped", s.frames_dropped},
                    {"frames_bad", s.frames_bad},
                    {"frames_missed", s.frames_missed},
                    {"images_unmatched", s.images_unmatched},
                    {"map_digest", digest_text(s.map_digest)},
                    {"frontier_digest", digest_text(s.frontier_digest)},
                    {"robots_known", s.robots_known},
                    {"robots_finished", s.robots_finished},
                    {"robots_in_map", s.robots_in_map},
                    {"keyframes_in_map", s.keyframes_in_map},
                    {"agreed", s.agreed},
                    {"map_agreed", s.map_agreed},
                    {"map_differs", s.map_differs},
                    {"pose", pose},
                    {"blocks_refused", s.blocks_refused},
                    {"waiting", printable(s.waiting)},
                    {"stuck", s.stuck},
                    {"consensus", s.consensus},
                    {"refused", s.refused}};
  return object.dump() + "\n";
}

Result<DaemonStatus> status_from_json(const std::string& text, const std::string& place) {
  try {
    const Json object = Json::parse(text);
    DaemonStatus s;
    object.at("state").get_to(s.state);
    object.at("frames").get_to(s.frames);
    object.at("frames_expected").get_to(s.frames_expected);
    object.at("tracked").get_to(s.tracked);
    object.at("keyframes").get_to(s.keyframes);
    s.map_digest = digest_from(object.at("map_digest"));
    s.frontier_digest = digest_from(object.at("frontier_digest"));
    object.at("robots_known").get_to(s.robots_known);
    object.at("robots_finished").get_to(s.robots_finished);
    object.at("robots_in_map").get_to(s.robots_in_map);
    object.at("agreed").get_to(s.agreed);
    s.keyframes_in_map = object.value("keyframes_in_map", s.keyframes_in_map);
    s.map_agreed = object.value("map_agreed", s.map_agreed);
    s.map_differs = object.value("map_differs", s.map_differs);
    if (object.contains("pose")) read_pose(object, s);
    s.frames_dropped = object.value("frames_dropped", s.frames_dropped);
    s.frames_bad = object.value("frames_bad", s.frames_bad);
    s.frames_missed = object.value("frames_missed", s.frames_missed);
    s.images_unmatched = object.value("images_unmatched", s.images_unmatched);
    s.blocks_refused = object.value("blocks_refused", s.blocks_refused);
    s.waiting = object.value("waiting", s.waiting);
    s.stuck = object.value("stuck", s.stuck);
    s.consensus = object.value("consensus", s.consensus);
    s.refused = object.value("refused", s.refused);
    return s;
  } catch (const Json::exception& error) {
    return Error{place, error.what()};
  }
}

Result<DaemonStatus> read_status(const std::string& file) {
  const auto text = read_text_file(file);
  return text ? status_from_json(*text, file) : text.error();
}

Status write_status(const std::string& file, const DaemonStatus& status) {
  return write_text_file(file, to_json(status), Durable::no);  // written again in a moment: not worth a disk's turn
}

}  // namespace onemap::daemon
