#include "mapping/team/pose_graph_solution.hpp"

#include <algorithm>
#include <array>

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
  constexpr std::array<std::string_view, static_cast<std::size_t>(LinkUse::count)> names{
      "used",         "no anchor yet", "better ones of the same anchors", "contradicts its chain's odometry",
      "chains apart", "outlier"};
  return use < LinkUse::count ? names[static_cast<std::size_t>(use)] : "count";
}

std::string_view to_string(JoinReason reason) {
  constexpr std::array<std::string_view, static_cast<std::size_t>(JoinReason::count)> names{"joined",
                                                                                            "no links",
                                                                                            "too few links that agree",
                                                                                            "all links from one place",
                                                                                            "look-alike",
                                                                                            "contradicts the graph"};
  return reason < JoinReason::count ? names[static_cast<std::size_t>(reason)] : "count";
}

const SolvedAnchor* GraphSolution::find(const AnchorId& id) const { return find_sorted(anchors, id); }
const LinkVerdict* GraphSolution::find(const LinkId& id) const { return find_sorted(links, id); }

}  // namespace onemap::mapping
