#pragma once
#include <vector>

#include "graph_index.hpp"

namespace onemap::mapping {

// Where each chain by itself has its anchors, and how unsure it is of the way between two of them: by odometry alone,
// or bent to its own loops (own_loops).
struct ChainFrames {
  std::vector<Pose> T_chain_anchor;
  // Covariance of the way from the chain's first anchor, as small motions in the chain's frame (so with the lever arms
  // of every step's rotation); that of the way between two anchors is the difference of theirs.
  std::vector<Matrix6d> covariance;
  std::vector<double> turn;  // trace of the covariance's rotation part: the same in every frame

  Matrix6d between(std::size_t a, std::size_t b) const {
    return a < b ? Matrix6d(covariance[b] - covariance[a]) : Matrix6d(covariance[a] - covariance[b]);
  }
  // Of the steps along the ring of two loops (a, b) and (c, d) of one chain: from a to c and from b to d. The two may
  // share steps, whose errors then cancel or count twice: what each step counts is a sum of signs.
  Matrix6d of_ring(std::size_t a, std::size_t b, std::size_t c, std::size_t d) const;
  // Puts an anchor there, but the first of its chain; the one before it must be where it stays.
  void place(const GraphIndex& index, std::size_t anchor, const Pose& T_chain_anchor);
};
ChainFrames chain_frames(const GraphIndex& index);  // by odometry alone

}  // namespace onemap::mapping
