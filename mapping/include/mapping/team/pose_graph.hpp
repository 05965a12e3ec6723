#pragma once
#include <map>
#include <vector>

#include "hal/base/result.hpp"
#include "mapping/team/pose_graph_config.hpp"
#include "mapping/team/pose_graph_input.hpp"
#include "mapping/team/pose_graph_solution.hpp"

namespace onemap::mapping {

// All robots' anchors with their odometry, own loops and links between robots, and the poses that fit them best. The
// answer is a function of what the graph holds and of the solution in use, not of the order in which it came. Used by
// one thread.
class PoseGraph {
 public:
  explicit PoseGraph(PoseGraphConfig config = {}) : config_(config) {}

  // The chain is these anchors now, ascending by keyframe; replaces what it was. The error says what is malformed, or
  // that the graph is full; then nothing changed.
  Status set_chain(const ChainId& chain, std::vector<ChainAnchor> anchors);
  // One more anchor at the end of the chain, which begins with it if there is none; or the last one again (its box
  // grows).
  Status set_anchor(const ChainId& chain, const ChainAnchor& anchor);
  void remove_chain(const ChainId& chain);  // its links stay, as no_anchor

  // Replaces the link of the same two keyframes. Its anchors may come later. The error says what is malformed, or that
  // the graph is full; then nothing changed.
  Status set_link(const GraphLink& link);
  void remove_link(const LinkId& link);

  const PoseGraphConfig& config() const { return config_; }
  const std::map<ChainId, std::vector<ChainAnchor>>& chains() const { return chains_; }
  const std::map<LinkId, GraphLink>& links() const { return links_; }
  std::size_t anchors() const { return anchor_count_; }
  std::size_t refused() const { return refused_; }  // chains, anchors and links that an error was the answer to

  // Which chains are joined, which links are right, and where every anchor is. With the solution in use: starts from
  // it, keeps its reference while that is in the map, anchors that would hardly move, and verdicts that hardly changed.
  // Of `in_use` only these are read: components' reference, anchors' component and pose, links' use.
  GraphSolution solve(const GraphSolution* in_use = nullptr) const;

 private:
  Status refuse(Error error);

  PoseGraphConfig config_;
  std::map<ChainId, std::vector<ChainAnchor>> chains_;
  std::map<LinkId, GraphLink> links_;
  std::size_t anchor_count_ = 0;
  std::size_t refused_ = 0;
};

}  // namespace onemap::mapping
