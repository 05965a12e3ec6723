#include "mapping/team/pose_graph_solution.hpp"

#include <algorithm>

namespace onemap::mapping {

namespace {

template <class Rows, class Id>
auto* find_sorted(const Rows& rows, const Id& id) {
  const auto at =
      std::lower_bound(rows.begin(), rows.end(), id, [](const auto& row, const Id& x) { return row.id < x; });
  return at != rows.end() && at->id == id ? &*at : nullptr;
}

}  // namespace

std::string_view to_string(LinkUse use) {
  switch (use) {
    case LinkUse::used:
      return "used";
    case LinkUse::no_anchor:
      return "no anchor yet";
    case LinkUse::surplus:
      return "better ones of the same anchors";
    case LinkUse::contradicts_chain:
      return "contradicts its chain's odometry";
    case LinkUse::chains_apart:
      return "chains apart";
    case LinkUse::outlier:
      return "outlier";
  }
  return "?";
}

std::string_view to_string(JoinReason reason) {
  switch (reason) {
    case JoinReason::joined:
      return "joined";
    case JoinReason::no_links:
      return "no links";
    case JoinReason::too_few_links:
      return "too few links that agree";
    case JoinReason::one_place:
      return "all links from one place";
    case JoinReason::unlinked_beside:
      return "much would lie side by side without a link";
    case JoinReason::look_alike:
      return "look-alike";
    case JoinReason::contradicts_others:
      return "contradicts links over third chains";
    case JoinReason::contradicts_graph:
      return "contradicts the graph";
  }
  return "?";
}

const SolvedAnchor* GraphSolution::find(const AnchorId& id) const { return find_sorted(anchors, id); }
const LinkVerdict* GraphSolution::find(const LinkId& id) const { return find_sorted(links, id); }

}  // namespace onemap::mapping
