#pragma once
#include <span>

#include "mapping/records/link.hpp"
#include "mapping/records/solution.hpp"

namespace onemap::mapping {

// Of the largest group of linked robots (election.hpp), the reference is the robot with the most and best matches (sum
// of inliers * ratio over its accepted links; ties: lowest id), and every robot linked to it directly or through others
// gets its transform by eq. (12) along the best links. The others stay out. Links may come in any order. Result sorted;
// with one robot alone, itself.
SolutionRecord solve(std::span<const RobotId> robots, std::span<const LinkRecord> links);

}  // namespace onemap::mapping
