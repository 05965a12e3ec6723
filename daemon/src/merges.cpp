#include "daemon/merges.hpp"

#include <algorithm>
#include <cmath>

#include "daemon/team_words.hpp"
#include "mapping/team/link_table.hpp"
#include "mapping/team/team_graph.hpp"

namespace onemap::daemon {

namespace {

constexpr double kDegrees = 57.29577951308232;

// Of the graph over the pair; joined where the graph says nothing: it has not been asked about these two.
std::string graph_words(const mapping::GraphSolution& graph, const mapping::TeamLink& link) {
  for (const mapping::PairVerdict& pair : graph.pairs)
    if (pair.a == link.a && pair.b == link.b && pair.used == 0) return std::string(mapping::to_string(pair.reason));
  return {};
}

Merge merge_of(const mapping::TeamLink& of, const mapping::GraphSolution& graph, const mapping::TeamLog& log) {
  const mapping::LinkRecord& link = *of.link;
  Merge merge;
  merge.a = chain_name(log, of.a);
  merge.b = chain_name(log, of.b);
  merge.refused = link.reason == mapping::LinkReason::accepted ? graph_words(graph, of) : link_words(link);
  merge.cloud_a = link.keyframe_a;
  merge.cloud_b = link.keyframe_b;
  merge.pairs = link.supporting_pairs;
  merge.inliers = link.inliers;
  merge.ratio = link.ratio_e4 * 1e-4;
  merge.error_mm = link.error_um * 1e-3;
  const mapping::Pose T = mapping::from_quantized(link.T_a_b);
  merge.distance_m = T.t.norm();
  merge.turn_deg = kDegrees * std::acos(std::clamp((T.R.trace() - 1) / 2, -1.0, 1.0));
  return merge;
}

}  // namespace

std::vector<Merge> merges_of(const mapping::TeamMap& team) {
  const auto links = mapping::counting_links(team.log());
  if (links.empty()) return {};
  const mapping::GraphSolution graph = mapping::solve_graph(team.log(), team.solution());
  std::vector<Merge> merges;
  merges.reserve(links.size());
  for (const mapping::TeamLink& link : links) merges.push_back(merge_of(link, graph, team.log()));
  return merges;
}

}  // namespace onemap::daemon
