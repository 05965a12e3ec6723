#pragma once
#include <vector>

#include "joining.hpp"

namespace onemap::mapping {

// Chains that joined pairs connect.
struct ChainGroup {
  std::vector<std::size_t> chains;  // of the index, ascending
  // Pairs (of the joining) that connect them without a ring, the best supported first; and the other joined ones.
  std::vector<std::size_t> tree, rings;
};

// The largest first, of equal ones that with the lowest chain.
std::vector<ChainGroup> group_chains(const GraphIndex& index, const Joining& joining);

// Eq. (12)'s choice: the chain of the group with the most and best matches (inliers of its joined pairs; ties: lowest).
std::size_t most_matched(const ChainGroup& group, const Joining& joining);

}  // namespace onemap::mapping
