#pragma once
#include <span>
#include <vector>

#include "mapping/records/trajectory.hpp"
#include "mapping/team/atlas.hpp"
#include "mapping/team/team_member.hpp"

// A robot's way where the map has its anchors: odometry, bent at each anchor.
namespace onemap::mapping {

// From the robot's own frame to the map's, around one anchor: what a keyframe that hangs on it, and the frames until
// the next keyframe, are moved by.
struct AnchorCorrection {
  std::uint32_t anchor = 0;
  Pose T_map_robot;
};
// Sorted by anchor; of anchors that the robot's keyframes name and the map has. `anchors` is sorted.
std::vector<AnchorCorrection> corrections(const TeamMember& member, std::span<const PlacedAnchor> anchors);

// In the map's frame; empty when the map has none of the robot's anchors.
std::vector<StampedPose> way_on_map(const TeamMember& member, std::span<const PlacedAnchor> anchors);
std::vector<QuantizedPose> keyframes_on_map(const TeamMember& member, std::span<const PlacedAnchor> anchors);

}  // namespace onemap::mapping
