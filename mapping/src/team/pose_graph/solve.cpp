#include <algorithm>

#include "mapping/team/pose_graph.hpp"
#include "report.hpp"

namespace onemap::mapping {

namespace {

std::vector<SolvedGroup> solve_all(const GraphIndex& index, const ChainFrames& frames,
                                   const std::vector<ChainGroup>& groups, const Joining& joining, const InUse& in_use,
                                   const PoseGraphConfig& config, SolveEffort& effort) {
  std::vector<SolvedGroup> out;
  out.reserve(groups.size());
  for (const ChainGroup& group : groups)
    out.push_back(solve_group(index, frames, group, joining, in_use, config, effort));
  return out;
}

// The links of a pair that its solved group uses.
std::vector<std::size_t> survivors(const ChainPair& pair, const std::vector<SolvedGroup>& groups) {
  std::vector<std::size_t> out;
  for (const SolvedGroup& group : groups)
    for (std::size_t link : pair.links) {
      const auto at = std::lower_bound(group.links.begin(), group.links.end(), link);
      if (at != group.links.end() && *at == link && group.used[static_cast<std::size_t>(at - group.links.begin())])
        out.push_back(link);
    }
  return out;
}

// Pairs whose links the solved graph ruled out do not join any more: what the graph says of a link counts more than
// what links say of each other.
void withdraw_unsupported(const GraphIndex& index, const ChainFrames& frames, const std::vector<SolvedGroup>& groups,
                          const JoinConfig& config, Joining& joining) {
  for (ChainPair& pair : joining.pairs) {
    if (pair.own() || !pair.joined()) continue;
    const std::vector<std::size_t> left = survivors(pair, groups);
    if (support(config, evidence_of(index, frames, left, config)) == JoinReason::joined) continue;
    pair.verdict.reason = JoinReason::contradicts_graph;
    pair.verdict.number = static_cast<double>(left.size());
  }
}

bool same_groups(const std::vector<ChainGroup>& a, const std::vector<ChainGroup>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const ChainGroup& x, const ChainGroup& y) { return x.chains == y.chains; });
}

bool same_component(const GraphComponent& x, const GraphComponent& y) {
  return x.chains == y.chains && x.reference == y.reference;
}

bool differs(const GraphSolution& now, const GraphSolution& before) {
  const auto used = [](const LinkVerdict& link) { return link.use == LinkUse::used; };
  const auto used_now_only = [&](const LinkVerdict& link) {
    const LinkVerdict* was = before.find(link.id);
    return used(link) && (was == nullptr || !used(*was));
  };
  return now.anchors.size() != before.anchors.size() ||
         std::any_of(now.anchors.begin(), now.anchors.end(), [](const SolvedAnchor& a) { return a.moved; }) ||
         !std::equal(now.components.begin(), now.components.end(), before.components.begin(), before.components.end(),
                     same_component) ||
         std::count_if(now.links.begin(), now.links.end(), used) !=
             std::count_if(before.links.begin(), before.links.end(), used) ||
         std::any_of(now.links.begin(), now.links.end(), used_now_only);
}

}  // namespace

GraphSolution PoseGraph::solve(const GraphSolution* in_use) const {
  const GraphIndex index = index_of(*this, config_.link_noise);
  ChainFrames frames = chain_frames(index);
  const InUse before = in_use_of(index, in_use);
  Joining joining = join_chains(index, config_.join, frames);
  SolveEffort effort{.pairs_compared = joining.compared};
  std::vector<ChainGroup> groups = group_chains(index, joining);
  std::vector<SolvedGroup> solved = solve_all(index, frames, groups, joining, before, config_, effort);
  while (true) {  // each time at least one pair less joins
    withdraw_unsupported(index, frames, solved, config_.join, joining);
    std::vector<ChainGroup> regrouped = group_chains(index, joining);
    if (same_groups(groups, regrouped)) break;
    groups = std::move(regrouped);
    solved = solve_all(index, frames, groups, joining, before, config_, effort);
  }
  GraphSolution out = report(index, joining, solved, before, config_.keep_within_m);
  out.effort = effort;
  out.changed = in_use == nullptr ? !out.anchors.empty() : differs(out, *in_use);
  return out;
}

}  // namespace onemap::mapping
