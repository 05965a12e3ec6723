#pragma once
#include <vector>

#include "chain_frame.hpp"

namespace onemap::mapping {

// What links that agree (of the index, all of one pair of chains) are worth as a witness.
struct Evidence {
  std::uint32_t links = 0;
  std::uint32_t places = 0;  // different ones, at least; it stops looking for more where there are enough
  double missed = 0;         // of what they lay side by side, the share without a link, beyond chance
  double share_of_way = 0;   // of the anchors of that chain which was less elsewhere, those near a link; of one place
};

// The links between two chains, or the own loops of one, and what they are worth.
struct ChainPair {
  std::size_t chain_a = 0, chain_b = 0;  // of the index, a <= b
  std::vector<std::size_t> links{};      // of the index, with anchors, ascending: those that the graph considers
  std::vector<std::size_t> agreeing{};   // the largest group of them
  std::size_t best = 0;                  // the one of the group with the most inliers: where the chains are joined
  std::uint64_t inliers = 0;             // of the group
  Evidence evidence{};                   // of the group
  PairVerdict verdict{};

  bool own() const { return chain_a == chain_b; }
  bool joined() const { return verdict.reason == JoinReason::joined; }
};

struct Joining {
  std::vector<ChainPair> pairs;  // sorted
  std::vector<LinkVerdict>
      verdicts;                // of every link of the index: no_anchor, surplus, contradicts_chain; others `used`
  std::uint32_t compared = 0;  // pairs of links
};

// Which pairs of chains may be joined by their links, and by which. `frames`, by odometry alone, are bent to the own
// loops that agree.
Joining join_chains(const GraphIndex& index, const JoinConfig& config, ChainFrames& frames);

Evidence evidence_of(const GraphIndex& index, const ChainFrames& frames, const std::vector<std::size_t>& links,
                     const JoinConfig& config);

// Whether that may join two chains.
JoinReason support(const JoinConfig& config, const Evidence& evidence);

}  // namespace onemap::mapping
