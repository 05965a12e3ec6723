#pragma once
#include <vector>

#include "solve_group.hpp"

namespace onemap::mapping {

// Solved groups (the first is the map) as the graph's answer; what hardly moved keeps its pose in use.
GraphSolution report(const GraphIndex& index, const Joining& joining, const std::vector<SolvedGroup>& groups,
                     const InUse& in_use, double keep_within_m);

}  // namespace onemap::mapping
