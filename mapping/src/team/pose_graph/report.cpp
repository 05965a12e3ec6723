#include "report.hpp"

#include <algorithm>

#include "keep.hpp"

namespace onemap::mapping {

namespace {

// Why a group is not in the map: what the pair with the most agreeing links between the two lacks.
void name_reason(const Joining& joining, const std::vector<std::size_t>& map, const SolvedGroup& group,
                 GraphComponent& component) {
  const auto in = [](const std::vector<std::size_t>& chains, std::size_t chain) {
    return std::binary_search(chains.begin(), chains.end(), chain);
  };
  const PairVerdict* best = nullptr;
  for (const ChainPair& pair : joining.pairs) {
    const bool between = (in(map, pair.chain_a) && in(group.group.chains, pair.chain_b)) ||
                         (in(map, pair.chain_b) && in(group.group.chains, pair.chain_a));
    if (between && (best == nullptr || pair.verdict.agree > best->agree)) best = &pair.verdict;
  }
  component.reason = best ? best->reason : JoinReason::no_links;
  component.number = best ? best->number : 0;
}

GraphComponent component_of(const GraphIndex& index, const SolvedGroup& group) {
  GraphComponent out;
  for (std::size_t chain : group.group.chains) out.chains.push_back(index.chains[chain].id);
  out.reference = index.ids[group.reference];
  out.anchors = static_cast<std::uint32_t>(group.anchors.size());
  return out;
}

void report_anchors(const GraphIndex& index, const SolvedGroup& group, std::uint32_t component, const InUse& in_use,
                    double keep_within_m, GraphSolution& out) {
  const auto& frame = in_use.anchors[group.reference];
  for (std::size_t i = 0; i < group.anchors.size(); ++i) {
    const std::size_t anchor = group.anchors[i];
    SolvedAnchor& solved = out.anchors[anchor];
    solved = {index.ids[anchor], component, quantize(group.poses[i]), true};
    const auto& before = in_use.anchors[anchor];
    // The reference keeps its pose, so who shared its frame before can be compared.
    if (!frame || !before || before->component != frame->component) continue;
    solved.moved = box_moved(*index.anchors[anchor], from_quantized(before->pose), from_quantized(solved.T_map_anchor),
                             keep_within_m);
    if (!solved.moved) solved.T_map_anchor = before->pose;
  }
}

void report_links(const SolvedGroup& group, GraphSolution& out) {
  for (std::size_t i = 0; i < group.links.size(); ++i) {
    LinkVerdict& verdict = out.links[group.links[i]];
    if (!group.used[i] && verdict.use == LinkUse::contradicts_chain) continue;  // says more than that it is an outlier
    verdict.use = group.used[i] ? LinkUse::used : LinkUse::outlier;
    verdict.number = group.squared_errors[i];
  }
}

void report_pairs(const Joining& joining, GraphSolution& out) {
  for (const ChainPair& pair : joining.pairs) {
    out.pairs.push_back(pair.verdict);
    out.pairs.back().used = static_cast<std::uint32_t>(std::count_if(
        pair.links.begin(), pair.links.end(), [&](std::size_t i) { return out.links[i].use == LinkUse::used; }));
  }
}

}  // namespace

GraphSolution report(const GraphIndex& index, const Joining& joining, const std::vector<SolvedGroup>& groups,
                     const InUse& in_use, double keep_within_m) {
  GraphSolution out;
  out.links = joining.verdicts;
  out.anchors.resize(index.ids.size());
  // Across groups nothing counts.
  for (LinkVerdict& link : out.links)
    if (link.use == LinkUse::used) link.use = LinkUse::chains_apart;
  for (std::size_t k = 0; k < groups.size(); ++k) {
    out.components.push_back(component_of(index, groups[k]));
    if (k > 0) name_reason(joining, groups[0].group.chains, groups[k], out.components.back());
    report_anchors(index, groups[k], static_cast<std::uint32_t>(k), in_use, keep_within_m, out);
    report_links(groups[k], out);
  }
  report_pairs(joining, out);
  return out;
}

}  // namespace onemap::mapping
