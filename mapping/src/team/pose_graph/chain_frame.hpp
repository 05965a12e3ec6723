#pragma once
#include <vector>

#include "graph_index.hpp"

namespace onemap::mapping {

// Where odometry alone has the anchors of all chains, and how unsure it is of the way between two of one chain.
struct ChainFrames {
  std::vector<Pose> T_chain_anchor;
  // Covariance of the way from the chain's first anchor, as small motions in the chain's frame (so with the lever arms
  // of every step's rotation); that of the way between two anchors is the difference of theirs.
  std::vector<Matrix6d> covariance;
  std::vector<double> turn;  // trace of the covariance's rotation part: the same in every frame

  Matrix6d between(std::size_t a, std::size_t b) const {
    return a < b ? Matrix6d(covariance[b] - covariance[a]) : Matrix6d(covariance[a] - covariance[b]);
  }
};
ChainFrames chain_frames(const GraphIndex& index);

}  // namespace onemap::mapping
