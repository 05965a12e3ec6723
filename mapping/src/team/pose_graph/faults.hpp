#pragma once
#include <string>

#include "mapping/team/pose_graph_input.hpp"

namespace onemap::mapping {

// What keeps it out of a graph, in words; empty: nothing. What is in records comes from strangers.
std::string fault_of(const ChainAnchor& anchor);
std::string fault_of(const GraphLink& link);

}  // namespace onemap::mapping
