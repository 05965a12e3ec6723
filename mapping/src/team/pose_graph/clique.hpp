#pragma once
#include <vector>

#include "agreement_graph.hpp"

namespace onemap::mapping {

// The largest group of vertices of `among` (ascending) that all agree with each other; ascending. Greedy first, from
// every vertex; that bounds which vertices can be in a larger group, and when 64 are left at most the answer is exact
// (branch and bound with greedy colouring, Tomita and Seki 2003), unless it takes more than `steps`. Equally large
// groups: always the same one for the same graph.
std::vector<std::size_t> largest_clique(const AgreementGraph& graph, const std::vector<std::size_t>& among,
                                        std::size_t steps);

}  // namespace onemap::mapping
