#pragma once
#include <utility>
#include <vector>

#include "chain_frame.hpp"

namespace onemap::mapping {

// What own loops say when a chain is walked along from its beginning.
struct FollowedLoops {
  std::vector<std::size_t> agreeing;                    // of the index, ascending
  std::vector<std::pair<std::size_t, double>> refused;  // the others, with the chi square of 6 degrees of freedom
};

// Walks along a chain and takes its loops in the order of their later ends. Each must fit where the way, bent by those
// that were taken before it, has its two ends, and half of the last few of those; then the way is bent to it, evenly
// since the one before. Odometry drifts to one side and not at random, so over a long way it would rule out what is
// right: here it is asked only for the way since the last loop. The farther away the last ones are, the less they say:
// so some that were wrong do not outvote for long what is right. `frames`: that chain's are bent.
FollowedLoops follow_loops(const GraphIndex& index, const IndexedChain& chain, const std::vector<std::size_t>& links,
                           double chi2, ChainFrames& frames);

}  // namespace onemap::mapping
