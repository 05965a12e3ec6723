#pragma once
#include <vector>

#include "daemon/report.hpp"
#include "mapping/team/team_map.hpp"

namespace onemap::daemon {

// Each pair of the team's maps that somebody verified, with what came of it: refused by the verifier, or by the pose
// graph that has all links before it, or joined. Sorted by pair. Solves the pose graph once.
std::vector<Merge> merges_of(const mapping::TeamMap& team);

}  // namespace onemap::daemon
