#include <fmt/format.h>

#include <algorithm>

#include "daemon/control/control_actions.hpp"
#include "daemon/control/metrics.hpp"
#include "daemon/control/replies.hpp"

namespace onemap::daemon {

namespace {
using Facts = std::function<RobotFacts()>;
using Handler = std::function<Result<Json>(const Request&)>;

// Answers with what a function makes of the facts.
Handler from(const Facts& facts, Json (*make)(const RobotFacts&)) {
  return [facts, make](const Request&) -> Result<Json> { return make(facts()); };
}

// An acknowledgement now, and the answer when it is done.
Handler later(const ControlActions::Action& action) {
  return [action](const Request& request) -> Result<Json> {
    if (!action) return Error{"", "not available: this daemon cannot do it"};
    action(request.object, request.later());
    return Json::object();
  };
}

Json pose_of(const RobotFacts& facts) {
  const DaemonStatus& s = facts.status;
  PoseNow pose;
  pose.tracking = s.tracking;
  pose.time = frame_time_from_ns(static_cast<std::int64_t>(s.pose_time_s * 1e9));
  pose.T_odom_camera = s.T_odom_camera;
  return pose_json(pose, s.T_map_odom);
}

Json metrics_of(const RobotFacts& facts) { return {{"text", metrics_text(facts)}}; }

Result<std::set<std::string, std::less<>>> classes_of(const Json& object) {
  std::set<std::string, std::less<>> classes;
  const auto given = object.find("classes");
  if (given == object.end()) {
    classes.insert(std::begin(kWatchable), std::end(kWatchable));
    return classes;
  }
  const std::string known = fmt::format("{}", fmt::join(kWatchable, ", "));
  if (!given->is_array()) return Error{"", "classes: expected a list of " + known};
  for (const Json& name : *given) {
    if (!name.is_string() || std::ranges::find(kWatchable, name.get_ref<const std::string&>()) == std::end(kWatchable))
      return Error{"", "classes: expected a list of " + known};
    classes.insert(name.get<std::string>());
  }
  return classes;
}

// From then on only these classes come; with enable false or an empty list none.
Result<Json> watch(const Request& request) {
  const auto enable = flag_in(request.object, "enable", true);
  if (!enable) return enable.error();
  auto classes = classes_of(request.object);
  if (!classes) return classes.error();
  request.watched = *enable ? std::move(*classes) : std::set<std::string, std::less<>>{};
  Json names = Json::array();
  for (const auto& name : request.watched) names.push_back(name);
  return Json{{"enable", !request.watched.empty()}, {"classes", std::move(names)}};
}
}  // namespace

std::vector<Command> control_commands(const std::function<RobotFacts()>& facts, const ControlActions& actions) {
  return {
      {"STATUS", Effect::reads, {}, "what the robot is doing", from(facts, status_json)},
      {"PEERS", Effect::reads, {}, "whom it hears, and who holds which map", from(facts, peers_json)},
      {"CONSENSUS", Effect::reads, {}, "what the team agrees on", from(facts, consensus_json)},
      {"MAP", Effect::reads, {}, "the map that it holds", from(facts, map_json)},
      {"POSE", Effect::reads, {}, "where the camera is", from(facts, pose_of)},
      {"CAMERAS", Effect::reads, {}, "what it sees with", from(facts, cameras_json)},
      {"METRICS", Effect::reads, {}, "counters and gauges as Prometheus text", from(facts, metrics_of)},
      {"DOCTOR", Effect::reads, {}, "what is wrong, and what to do", from(facts, doctor_json)},
      {"WATCH", Effect::reads, {"enable", "classes"}, "hear of changes unasked", watch},
      {"SNAPSHOT", Effect::changes, {"maps", "views", "kinds"}, "draw the map as it is now", later(actions.snapshot)},
      {"SAVE", Effect::changes, {"path"}, "write the map", later(actions.save)},
      {"LOAD", Effect::changes, {"path"}, "go on in a map, or look whether it is whole", later(actions.load)},
      {"RECORD", Effect::changes, {"enable", "path"}, "keep the camera's frames", later(actions.record)},
      {"WHY", Effect::reads, {"a", "b"}, "why two robots are joined, or not", later(actions.why)},
      {"UNMERGE", Effect::changes, {"a", "b"}, "take the join of two robots back", later(actions.unmerge)},
      {"MERGE", Effect::changes, {"a", "b"}, "let what joins two robots count again", later(actions.merge)},
  };
}

}  // namespace onemap::daemon
