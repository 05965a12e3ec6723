// What happened in the team, for control clients.
#include <algorithm>

#include "daemon/control/replies.hpp"
#include "daemon/link_tally.hpp"
#include "daemon/report.hpp"
#include "hal/base/text.hpp"

namespace onemap::daemon {

using control::Json;

namespace {
struct AsJson {
  Json operator()(const mapping::RobotJoined& e) const {
    return {{"event", "robot_joined"}, {"robot", e.robot.name()}, {"camera", printable(e.camera)}};
  }
  Json operator()(const mapping::RobotFinished& e) const {
    return {{"event", "robot_finished"},   {"robot", e.robot.name()},         {"frames", e.record.frames},
            {"tracked", e.record.tracked}, {"keyframes", e.record.keyframes}, {"submaps", e.record.submaps}};
  }
  Json operator()(const mapping::RobotGone& e) const {
    return {{"event", "robot_gone"}, {"robot", e.robot.name()}, {"silent_s", to_seconds(e.silent)}};
  }
  Json operator()(const mapping::RobotBack& e) const { return {{"event", "robot_back"}, {"robot", e.robot.name()}}; }
  Json operator()(const mapping::LinkLooked& e) const {
    const mapping::LinkRecord& link = e.link;
    const auto reason = std::min(static_cast<std::size_t>(link.reason), LinkTally::kReasons - 1);
    return {{"event", "link"},
            {"a", link.a.name()},
            {"b", link.b.name()},
            {"by", e.author.robot.name()},
            {"accepted", link.reason == mapping::LinkReason::accepted},
            {"reason", LinkTally::reason(reason)},
            {"measured", link.measured},
            {"again", e.again},
            {"supporting_pairs", link.supporting_pairs},
            {"inliers", link.inliers},
            {"error_mm", link.error_um * 1e-3}};
  }
  Json operator()(const mapping::PairRuled& e) const {
    return {{"event", "pair_ruled"},
            {"a", e.ruling.a.robot.name()},
            {"b", e.ruling.b.robot.name()},
            {"by", e.by.name()},
            {"apart", e.ruling.apart}};
  }
  Json operator()(const mapping::RecordRefused& e) const {
    return {{"event", "record_refused"},
            {"robot", e.id.log.robot.name()},
            {"kind", e.kind},
            {"reason", printable(e.reason)}};
  }
  Json operator()(const mapping::DeciderPassedOver& e) const {
    return {{"event", "decider_passed_over"}, {"robot", e.robot.name()}, {"published", e.published}};
  }
  Json operator()(const mapping::MapFused& e) const {
    Json robots = Json::array();
    for (const auto& robot : e.solution.robots) robots.push_back(robot.chain.robot.name());
    return {{"event", "map_fused"},
            {"digest", digest_text(e.digest)},
            {"final", e.final},
            {"robots", std::move(robots)},
            {"submaps", e.submaps},
            {"blocks", e.blocks},
            {"blocks_refused", e.blocks_refused}};
  }
  Json operator()(const mapping::MapSettled& e) const {
    return {{"event", "map_settled"}, {"digest", digest_text(e.digest)}, {"blocks", e.blocks}};
  }
};
}  // namespace

Json event_json(const mapping::TeamEvent& event) { return std::visit(AsJson{}, event); }

}  // namespace onemap::daemon
