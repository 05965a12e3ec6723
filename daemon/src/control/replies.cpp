#include "daemon/control/replies.hpp"

#include <algorithm>

#include "comms/udp/udp_port.hpp"
#include "daemon/control/pose_array.hpp"
#include "daemon/report.hpp"
#include "daemon/standing.hpp"
#include "hal/base/text.hpp"

namespace onemap::daemon {

using control::Json;

namespace {
double seconds_between(Instant earlier, Instant later) {
  return to_seconds(std::max(Duration::zero(), later - earlier));
}

double round_to(double value, double step) { return std::round(value / step) * step; }

// Bytes by kind; DATA by lane. Kinds that did not occur are left out.
Json traffic_json(const comms::Traffic::Way& way) {
  static constexpr std::array<const char*, kLaneCount> kLanes{"control", "poses", "features", "voxels", "imagery"};
  Json object{{"headers", way.frames[0]}};
  for (const comms::FrameType type : comms::kFrameTypes)
    if (const std::uint64_t bytes = way.frames[index_of(type)]; bytes > 0) object[std::string(name(type))] = bytes;
  for (std::size_t lane = 0; lane < kLaneCount; ++lane)
    if (way.data[lane] > 0) object[kLanes[lane]] = way.data[lane];
  return object;
}

Json neighbour_json(const comms::NeighbourStatus& n, const RobotFacts& facts) {
  return {{"robot", n.robot.name()},
          {"endpoint", comms::to_string(n.endpoint)},
          {"alive", n.alive},
          {"silent_s", round_to(seconds_between(n.last_heard, facts.now), 0.001)},
          {"loss", round_to(n.loss, 0.0001)},
          {"loss_there", round_to(n.loss_there, 0.0001)},
          {"etx", round_to(n.etx(), 0.01)},
          {"round_trip_ms", round_to(to_seconds(n.round_trip) * 1e3, 0.001)},
          {"bytes_in", n.bytes_in},
          {"bytes_out", n.bytes_out},
          {"bytes_today", n.bytes_today},
          {"within_budget", n.within_budget},
          {"rate", round_to(n.rate, 1)},
          {"queue_ms", round_to(to_seconds(n.queue) * 1e3, 0.001)},
          {"traffic", {{"in", traffic_json(n.traffic.in)}, {"out", traffic_json(n.traffic.out)}}},
          {"map_digest", digest_text(n.map_digest)},
          {"same_map", n.map_digest != 0 && n.map_digest == facts.status.map_digest},
          {"same_records", n.frontier_digest == facts.radio.frontier_digest},
          {"finished", (n.flags & comms::kStatusFinished) != 0},
          {"life", n.incarnation}};
}

// A robot of the team: those heard over others, too.
Json robot_json(const RobotId& robot, Instant sign, const RobotFacts& facts) {
  const auto digest = facts.radio.map_digests.find(robot);
  const bool own = robot.name() == facts.id;
  const std::uint64_t holds = own                                       ? facts.status.map_digest
                              : digest == facts.radio.map_digests.end() ? 0
                                                                        : digest->second;
  return {{"robot", robot.name()},
          {"own", own},
          {"silent_s", round_to(own ? 0 : seconds_between(sign, facts.now), 0.001)},
          {"records_complete", own || facts.radio.records_complete.contains(robot)},
          {"gone", facts.team.gone.contains(robot)},
          {"map_digest", digest_text(holds)},
          {"same_map", holds != 0 && holds == facts.status.map_digest}};
}

Json links_json(const LinkTally& links) {
  Json refused = Json::object();
  for (std::size_t i = 1; i < LinkTally::kReasons; ++i)
    if (links.looked[i] > 0) refused[LinkTally::reason(i)] = links.looked[i];
  return {{"looked_at", links.proposed()}, {"accepted", links.looked[0]}, {"refused", std::move(refused)}};
}

template <class Set>
Json names(const Set& robots) {
  Json list = Json::array();
  for (const RobotId& robot : robots) list.push_back(robot.name());
  return list;
}

Json poses(const std::optional<mapping::Pose>& pose) { return pose ? pose_array(*pose) : Json(); }
}  // namespace

std::optional<mapping::Pose> map_correction(const TeamView& team, const PoseNow& pose) {
  if (!team.T_map_odometry || team.chain != pose.chain) return std::nullopt;
  return mapping::from_quantized(*team.T_map_odometry) * pose.T_odom_robot.inverse();
}

Json greeting_json(const std::string& id, const std::string& version) {
  return {{"class", "VERSION"},
          {"program", "onemapd"},
          {"version", version},
          {"protocol", control::kProtocolMajor},
          {"protocol_minor", control::kProtocolMinor},
          {"robot", id}};
}

Json status_json(const RobotFacts& facts) {
  Json object{{"robot", facts.id}, {"life", facts.life}, {"uptime_s", round_to(facts.uptime_s, 0.001)}};
  object.update(Json::parse(to_json(facts.status)));
  object["camera"] = printable(facts.camera.description);
  object["camera_away"] = facts.camera.away;
  object["ms_per_frame"] = {{"p50", facts.pipeline.costs.frame.quantiles.p50_ms},
                            {"p95", facts.pipeline.costs.frame.quantiles.p95_ms},
                            {"p99", facts.pipeline.costs.frame.quantiles.p99_ms}};
  object["rss_mb"] = round_to(facts.rss_mb, 0.1);
  object["out"] = printable(facts.place.out);
  return object;
}

Json peers_json(const RobotFacts& facts) {
  Json peers = Json::array(), robots = Json::array();
  for (const comms::NeighbourStatus& neighbour : facts.radio.neighbours)
    peers.push_back(neighbour_json(neighbour, facts));
  for (const auto& [robot, sign] : facts.radio.last_sign) robots.push_back(robot_json(robot, sign, facts));
  return {{"alone", facts.alone},
          {"listen", facts.listen},
          {"peers", std::move(peers)},
          {"robots", std::move(robots)},
          {"never_heard", facts.radio.peers_never_heard},
          {"id_also_used_at", facts.radio.id_also_used_at},
          {"bytes_sent", facts.radio.bytes_sent},
          {"bytes_received", facts.radio.bytes_received},
          {"records_missing", facts.radio.records_missing}};
}

// Means over the team, but for team_size; what is not known yet is null.
Json consensus_json(const RobotFacts& facts) {
  const comms::ScalarsView& view = facts.radio.scalars;
  Json out{{"alone", facts.alone}, {"settled", view.settled}, {"exchanges", view.exchanges}};
  for (std::size_t k = 0; k < comms::kScalars; ++k) {
    const comms::ScalarValue& value = view.values[k];
    out[name(static_cast<comms::Scalar>(k))] = {{"own", value.known ? Json(value.own) : Json()},
                                                {"agreed", value.known ? Json(value.agreed) : Json()}};
  }
  const auto& light = view.values[static_cast<std::size_t>(comms::Scalar::brightness)];
  out["colour_gain"] = light.known && light.own > 0 ? Json(light.agreed / light.own) : Json();
  return out;
}

Json map_json(const RobotFacts& facts) {
  const DaemonStatus& s = facts.status;
  return {{"digest", digest_text(s.map_digest)},
          {"agreed", s.map_agreed},
          {"differs", s.map_differs},
          {"settled", facts.team.settled},
          {"robots_known", s.robots_known},
          {"robots_in_map", s.robots_in_map},
          {"gone", names(facts.team.gone)},
          {"cut_short", names(facts.team.cut_short)},
          {"blocks", facts.team.blocks},
          {"blocks_most", facts.global_blocks_most},
          {"blocks_refused", facts.team.blocks_refused},
          {"local_blocks", facts.pipeline.blocks},
          {"local_blocks_most", facts.local_blocks_most},
          {"local_blocks_refused", s.blocks_refused},
          {"keyframes", s.keyframes},
          {"links", links_json(facts.links)},
          {"merge_ms", round_to(to_seconds(facts.team.merge) * 1e3, 1)},
          {"T_map_odom", poses(s.T_map_odom)},
          {"waiting", printable(s.waiting)},
          {"refused", s.refused}};
}

Json cameras_json(const RobotFacts& facts) {
  const hal::Intrinsics& k = facts.camera.intrinsics;
  Json camera{{"address", printable(facts.camera.address)},
              {"description", printable(facts.camera.description)},
              {"limits", printable(facts.camera.limits)},
              {"live", facts.camera.live},
              {"away", facts.camera.away},
              {"ended", facts.camera.ended},
              {"width", k.width},
              {"height", k.height},
              {"fx", k.fx},
              {"fy", k.fy},
              {"cx", k.cx},
              {"cy", k.cy},
              {"distortion", {k.k1, k.k2, k.p1, k.p2, k.k3}},
              {"depth_scale", k.depth_scale},
              {"frames", facts.capture.grabbed},
              {"bad", facts.capture.bad},
              {"dropped", facts.capture.dropped},
              {"missed", facts.capture.missed},
              {"unmatched", facts.capture.unmatched},
              {"times_gone", facts.capture.gone}};
  if (const auto& look = facts.pipeline.look)
    camera["look"] = {{"valid", look->valid}, {"near_m", look->near_m}, {"median_m", look->median_m},
                      {"far_m", look->far_m}, {"step_m", look->step_m}, {"brightness", look->brightness}};
  return {{"cameras", Json::array({std::move(camera)})}};
}

Json pose_json(const PoseNow& pose, const std::optional<mapping::Pose>& T_map_odom) {
  return {{"tracking", pose.tracking},
          {"time_s", to_seconds(pose.time.time_since_epoch())},
          {"T_odom_camera", pose_array(pose.T_odom_camera)},
          {"T_map_odom", poses(T_map_odom)},
          {"T_map_camera", T_map_odom ? pose_array(*T_map_odom * pose.T_odom_camera) : Json()}};
}

}  // namespace onemap::daemon
