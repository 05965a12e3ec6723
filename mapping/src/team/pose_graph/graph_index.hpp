#pragma once
#include <map>
#include <vector>

#include "graph_edge.hpp"
#include "mapping/team/pose_graph.hpp"

namespace onemap::mapping {

struct IndexedChain {
  ChainId id;
  std::size_t first = 0, count = 0;  // its anchors
};

struct IndexedLink {
  LinkId id;
  const GraphLink* link = nullptr;
  bool has_anchors = false;  // both ends are in the graph; else nothing below is set
  std::size_t chain_a = 0, chain_b = 0;
  GraphEdge edge{};  // between anchors of the index
};

// What a graph holds in one fixed order: anchors, chains and links sorted by id. Points into the graph.
struct GraphIndex {
  std::vector<IndexedChain> chains;
  std::vector<AnchorId> ids;
  std::vector<const ChainAnchor*> anchors;
  std::vector<std::size_t> chain_of;
  std::vector<IndexedLink> links;

  std::size_t first_of_chain(std::size_t anchor) const { return chains[chain_of[anchor]].first; }
};
GraphIndex index_of(const PoseGraph& graph, const LinkNoise& noise);

// The step that leads to an anchor; not for the first one of a chain.
GraphEdge odometry_edge(const GraphIndex& index, std::size_t anchor);

}  // namespace onemap::mapping
