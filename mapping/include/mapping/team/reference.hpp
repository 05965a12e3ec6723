#pragma once
#include <span>

#include "mapping/records/link.hpp"
#include "mapping/records/solution.hpp"

namespace onemap::mapping {

// The robot that decides: the lowest id of those present (anyone can compute it, anyone can take over).
RobotId elect(std::span<const RobotId> robots);

// The reference is the robot with the most and best matches (sum of inliers * ratio over its accepted links; ties:
// lowest id) and every robot linked to it directly or through others gets its transform by eq. (12) along the best
// links. Robots without links stay out. Links may come in any order. Result sorted; with one robot alone, itself.
SolutionRecord solve(std::span<const RobotId> robots, std::span<const LinkRecord> links);

}  // namespace onemap::mapping
