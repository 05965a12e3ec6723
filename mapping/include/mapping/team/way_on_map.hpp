#pragma once
#include <cstddef>
#include <vector>

#include "mapping/records/solution.hpp"
#include "mapping/records/trajectory.hpp"
#include "mapping/team/team_member.hpp"

// A robot's way where the map has its anchors: its odometry, bent at each anchor. Between two keyframes the bend goes
// over from one anchor's to the other's evenly in time, so that the way has no steps. Empty when the solution is of
// another life, or the robot has no anchor.
namespace onemap::mapping {

std::vector<StampedPose> way_on_map(const TeamMember& member, const SolvedRobot& solved);

struct KeyframeOnMap {
  std::size_t position = 0;  // in the robot's log
  QuantizedPose T_map_keyframe;
};
// Those whose places are known.
std::vector<KeyframeOnMap> keyframes_on_map(const TeamMember& member, const SolvedRobot& solved);

// From the robot's odometry frame to the map's, where it is now: at its last anchor (the correction of ROS REP 105,
// which may jump when the map is solved anew; the odometry never does).
QuantizedPose correction_now(const TeamMember& member, const SolvedRobot& solved);

}  // namespace onemap::mapping
