#include "joining.hpp"

#include <algorithm>
#include <map>
#include <numeric>

#include "clique.hpp"
#include "pair_links.hpp"
#include "triangles.hpp"

namespace onemap::mapping {

namespace {

using Links = std::vector<std::size_t>;  // of the index

// The best by inliers, ties by id; ascending.
Links best_by_inliers(const GraphIndex& index, Links links, std::size_t most) {
  std::stable_sort(links.begin(), links.end(), [&](std::size_t x, std::size_t y) {
    return index.links[x].link->inliers > index.links[y].link->inliers;
  });
  if (links.size() > most) links.resize(most);
  std::sort(links.begin(), links.end());
  return links;
}

void drop_surplus(const GraphIndex& index, std::uint32_t most, std::vector<LinkVerdict>& verdicts) {
  std::map<std::pair<std::size_t, std::size_t>, Links> by_anchors;
  for (std::size_t i = 0; i < index.links.size(); ++i)
    if (index.links[i].has_anchors) by_anchors[{index.links[i].edge.a, index.links[i].edge.b}].push_back(i);
  for (auto& [anchors, links] : by_anchors) {
    std::stable_sort(links.begin(), links.end(), [&](std::size_t x, std::size_t y) {
      return index.links[x].link->inliers > index.links[y].link->inliers;
    });
    for (std::size_t rank = most; rank < links.size(); ++rank)
      verdicts[links[rank]] = {verdicts[links[rank]].id, LinkUse::surplus, static_cast<double>(rank + 1)};
  }
}

std::vector<ChainPair> pairs_of(const GraphIndex& index, const std::vector<LinkVerdict>& verdicts) {
  std::map<std::pair<std::size_t, std::size_t>, Links> by_chains;
  for (std::size_t i = 0; i < index.links.size(); ++i)
    if (verdicts[i].use == LinkUse::used) by_chains[{index.links[i].chain_a, index.links[i].chain_b}].push_back(i);
  std::vector<ChainPair> out;
  for (auto& [chains, links] : by_chains) {
    ChainPair pair{.chain_a = chains.first, .chain_b = chains.second, .links = std::move(links)};
    pair.verdict.a = index.chains[chains.first].id;
    pair.verdict.b = index.chains[chains.second].id;
    out.push_back(std::move(pair));
  }
  return out;
}

// The links that odometry does not rule out.
Links within_odometry(const GraphIndex& index, const ChainFrames& frames, const Links& links, double chi2,
                      std::vector<LinkVerdict>& verdicts) {
  Links out;
  for (std::size_t i : links) {
    const double surprise = against_odometry(frames, index.links[i].edge);
    if (surprise <= chi2)
      out.push_back(i);
    else
      verdicts[i] = {verdicts[i].id, LinkUse::contradicts_chain, surprise};
  }
  return out;
}

// Those that contradict the group: they disagree with more than half of it. (A right link that misses one or two of
// its kind by chance is not of another opinion.)
std::vector<std::size_t> opponents(const AgreementGraph& graph, const std::vector<std::size_t>& group) {
  std::vector<std::size_t> out;
  for (std::size_t v = 0; v < graph.size(); ++v) {
    if (std::binary_search(group.begin(), group.end(), v)) continue;
    const auto agree = std::count_if(group.begin(), group.end(), [&](std::size_t u) { return graph.agree(u, v); });
    if (2 * static_cast<std::size_t>(agree) < group.size()) out.push_back(v);
  }
  return out;
}

// The member of the group with the most inliers stands for it; ties: the first.
std::size_t best_of(const GraphIndex& index, const Links& group) {
  return *std::max_element(group.begin(), group.end(), [&](std::size_t x, std::size_t y) {
    return index.links[x].link->inliers < index.links[y].link->inliers;
  });
}

void find_groups(const GraphIndex& index, const ChainFrames& frames, const JoinConfig& config, const Links& links,
                 ChainPair& pair) {
  std::vector<const GraphEdge*> edges;
  for (std::size_t i : links) edges.push_back(&index.links[i].edge);
  const AgreementGraph graph = agreement_of(frames, edges, pair.own(), config.chi2);
  std::vector<std::size_t> all(links.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  const std::vector<std::size_t> group = largest_clique(graph, all, config.clique_steps);
  const auto second = largest_clique(graph, opponents(graph, group), config.clique_steps);
  for (std::size_t v : group) {
    pair.agreeing.push_back(links[v]);
    pair.inliers += index.links[links[v]].link->inliers;
  }
  pair.verdict.links = static_cast<std::uint32_t>(links.size());
  pair.verdict.agree = static_cast<std::uint32_t>(group.size());
  pair.verdict.second = static_cast<std::uint32_t>(second.size());
  pair.evidence = evidence_of(index, frames, pair.agreeing, config);
  pair.verdict.places = pair.evidence.places;
  if (!group.empty()) pair.best = best_of(index, pair.agreeing);
}

void judge(const JoinConfig& config, ChainPair& pair) {
  PairVerdict& verdict = pair.verdict;
  verdict.reason = support(config, pair.evidence);
  if (pair.own()) verdict.reason = verdict.agree < config.own_links ? JoinReason::too_few_links : JoinReason::joined;
  verdict.number = verdict.agree;
  if (verdict.agree == 0) verdict.reason = JoinReason::no_links;
  if (verdict.reason == JoinReason::no_links || verdict.reason == JoinReason::too_few_links) return;
  if (verdict.second > config.second_group_share * verdict.agree) {
    verdict.reason = JoinReason::look_alike;
    verdict.number = verdict.second;
  }
}

}  // namespace

Joining join_chains(const GraphIndex& index, const ChainFrames& frames, const JoinConfig& config) {
  Joining out;
  for (const IndexedLink& link : index.links)
    out.verdicts.push_back({link.id, link.has_anchors ? LinkUse::used : LinkUse::no_anchor, 0});
  drop_surplus(index, config.links_per_anchor_pair, out.verdicts);
  out.pairs = pairs_of(index, out.verdicts);
  for (ChainPair& pair : out.pairs) {
    Links links = pair.links;
    if (pair.own()) links = within_odometry(index, frames, links, config.chi2, out.verdicts);
    links = best_by_inliers(index, std::move(links), config.links_compared);
    out.compared +=
        static_cast<std::uint32_t>(links.size() * (links.size() - std::min<std::size_t>(1, links.size())) / 2);
    find_groups(index, frames, config, links, pair);
    judge(config, pair);
  }
  doubt_triangles(index, frames, config, out.pairs);
  return out;
}

}  // namespace onemap::mapping
