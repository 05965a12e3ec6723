#pragma once
#include <optional>
#include <vector>

#include "mapping/records/solution.hpp"
#include "mapping/team/team_member.hpp"

// Where a solution puts what a robot has seen. Integers from integers, so every machine puts it in the same place.
namespace onemap::mapping {

// All of the robot's anchors among its first `keyframes` in the global frame, sorted: those of the solution where it
// has them; between two of these the way is bent evenly from the one to the other; before the first and behind the last
// it goes on by odometry. Empty when the solution is of another life.
std::vector<PlacedAnchor> placed_anchors(const TeamMember& member, const SolvedRobot& solved,
                                         std::size_t keyframes = SIZE_MAX);

// The share of the way from a to b, 0 to 1: evenly in rotation and translation, which are close to each other (of what
// is turned by nearly half a turn, the nearer of the two).
Pose between(const Pose& a, const Pose& b, double share);

// The solution's entry for this life; nullptr: it is not in the map.
const SolvedRobot* find_solved(const SolutionRecord& solution, const ChainId& chain);

}  // namespace onemap::mapping
