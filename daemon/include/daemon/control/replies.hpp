#pragma once
#include "control/protocol.hpp"
#include "daemon/control/robot_facts.hpp"
#include "mapping/team/team_event.hpp"
#include "mapping/team/why.hpp"

// What control clients are told, as JSON without its class (onemap-control.7 says the same in prose).
namespace onemap::daemon {

control::Json greeting_json(const std::string& id, const std::string& version);
control::Json status_json(const RobotFacts& facts);
control::Json peers_json(const RobotFacts& facts);
control::Json consensus_json(const RobotFacts& facts);
control::Json map_json(const RobotFacts& facts);
control::Json cameras_json(const RobotFacts& facts);
// T_map_odom: where odometry is in the global map, if it is; see map_correction().
control::Json pose_json(const PoseNow& pose, const std::optional<mapping::Pose>& T_map_odom);
// What is wrong with the robot, as far as it can tell itself: [{"about", "ok", "text", "advice"}].
control::Json doctor_json(const RobotFacts& facts);
control::Json why_json(const mapping::Why& why);
control::Json event_json(const mapping::TeamEvent& event);

// From smooth odometry to the global map; nothing while this chain is not in it.
std::optional<mapping::Pose> map_correction(const TeamView& team, const PoseNow& pose);

}  // namespace onemap::daemon
