#include "graph_index.hpp"

#include <algorithm>
#include <optional>

namespace onemap::mapping {

namespace {

std::optional<std::size_t> find_anchor(const GraphIndex& index, const AnchorId& id) {
  const auto at = std::lower_bound(index.ids.begin(), index.ids.end(), id);
  if (at == index.ids.end() || *at != id) return std::nullopt;
  return static_cast<std::size_t>(at - index.ids.begin());
}

IndexedLink indexed(const GraphIndex& index, const LinkId& id, const GraphLink& link, const LinkNoise& noise) {
  IndexedLink out{.id = id, .link = &link};
  const auto a = find_anchor(index, link.a.anchor_id()), b = find_anchor(index, link.b.anchor_id());
  if (!a || !b) return out;
  out.has_anchors = true;
  out.edge = edge_of(link, noise);
  out.edge.a = *a;
  out.edge.b = *b;
  out.chain_a = index.chain_of[*a];
  out.chain_b = index.chain_of[*b];
  return out;
}

}  // namespace

GraphIndex index_of(const PoseGraph& graph, const LinkNoise& noise) {
  GraphIndex index;
  for (const auto& [id, anchors] : graph.chains()) {
    index.chains.push_back({id, index.ids.size(), anchors.size()});
    for (const ChainAnchor& anchor : anchors) {
      index.ids.push_back({id, anchor.keyframe});
      index.anchors.push_back(&anchor);
      index.chain_of.push_back(index.chains.size() - 1);
    }
  }
  for (const auto& [id, link] : graph.links()) index.links.push_back(indexed(index, id, link, noise));
  return index;
}

GraphEdge odometry_edge(const GraphIndex& index, std::size_t anchor) {
  const ChainAnchor& to = *index.anchors[anchor];
  return {anchor - 1, anchor, to.T_previous_anchor, to.information};
}

}  // namespace onemap::mapping
