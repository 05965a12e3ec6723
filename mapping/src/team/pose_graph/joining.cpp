#include "joining.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <numeric>
#include <utility>

#include "clique.hpp"
#include "own_loops.hpp"
#include "pair_links.hpp"
#include "triangles.hpp"

namespace onemap::mapping {

namespace {

using Links = std::vector<std::size_t>;  // of the index

std::uint32_t pairs_among(std::size_t links) {
  return static_cast<std::uint32_t>(links * (links - std::min<std::size_t>(1, links)) / 2);
}

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
Links within_odometry(const GraphIndex& index, const ChainFrames& frames, const Links& links, double chi2) {
  Links out;
  for (std::size_t i : links)
    if (against_odometry(frames, index.links[i].edge) <= chi2) out.push_back(i);
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

Links of(const Links& links, const std::vector<std::size_t>& chosen) {
  Links out;
  for (std::size_t v : chosen) out.push_back(links[v]);
  return out;
}

AgreementGraph agreement_between(const GraphIndex& index, const ChainFrames& frames, const Links& links, bool own,
                                 double chi2) {
  std::vector<const GraphEdge*> edges;
  for (std::size_t i : links) edges.push_back(&index.links[i].edge);
  return agreement_of(frames, edges, own, chi2);
}

std::vector<std::size_t> all_of(const Links& links) {
  std::vector<std::size_t> out(links.size());
  std::iota(out.begin(), out.end(), std::size_t{0});
  return out;
}

// The links that agree, and the most that agree on something else.
struct Groups {
  Links agreeing;
  std::size_t second = 0;
};

Groups find_groups(const GraphIndex& index, const ChainFrames& frames, const JoinConfig& config, const Links& links,
                   bool own) {
  const AgreementGraph graph = agreement_between(index, frames, links, own, config.chi2);
  const std::vector<std::size_t> group = largest_clique(graph, all_of(links), config.clique_steps);
  return {of(links, group), largest_clique(graph, opponents(graph, group), config.clique_steps).size()};
}

// Of one chain, as they follow each other along the way, which is bent to them. Where more of them agree by odometry
// alone, the first ones were wrong, and these count; the way stays as it is.
Groups find_own_groups(const GraphIndex& index, const JoinConfig& config, const ChainPair& pair, ChainFrames& frames,
                       Joining& joining) {
  const ChainFrames by_itself = frames;
  const FollowedLoops followed = follow_loops(index, index.chains[pair.chain_a], pair.links, config.chi2, frames);
  Groups out{followed.agreeing, 0};
  const auto contradicts = [&](std::size_t link, double chi2) {
    joining.verdicts[link] = {joining.verdicts[link].id, LinkUse::contradicts_chain, chi2};
  };
  if (!followed.refused.empty()) {
    const Links near = within_odometry(index, by_itself, pair.links, config.chi2);
    const Links links = best_by_inliers(index, near, config.links_compared);
    joining.compared += pairs_among(links.size());
    Groups by_odometry = find_groups(index, by_itself, config, links, true);
    if (by_odometry.agreeing.size() > followed.agreeing.size()) {
      for (std::size_t link : pair.links)
        if (!std::ranges::binary_search(near, link))
          contradicts(link, against_odometry(by_itself, index.links[link].edge));
      frames = by_itself;
      return by_odometry;
    }
    Links others;
    std::ranges::copy_if(links, std::back_inserter(others),
                         [&](std::size_t link) { return !std::ranges::binary_search(followed.agreeing, link); });
    const AgreementGraph graph = agreement_between(index, by_itself, others, true, config.chi2);
    out.second = largest_clique(graph, all_of(others), config.clique_steps).size();
  }
  for (const auto& [link, misfit] : followed.refused) contradicts(link, misfit);
  return out;
}

void weigh(const GraphIndex& index, const ChainFrames& frames, const JoinConfig& config, Groups groups,
           ChainPair& pair) {
  for (std::size_t link : groups.agreeing) pair.inliers += index.links[link].link->inliers;
  pair.agreeing = std::move(groups.agreeing);
  pair.verdict.agree = static_cast<std::uint32_t>(pair.agreeing.size());
  pair.verdict.second = static_cast<std::uint32_t>(groups.second);
  pair.evidence = evidence_of(index, frames, pair.agreeing, config);
  pair.verdict.places = pair.evidence.places;
  if (!pair.agreeing.empty()) pair.best = best_of(index, pair.agreeing);
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

Joining join_chains(const GraphIndex& index, const JoinConfig& config, ChainFrames& frames) {
  Joining out;
  for (const IndexedLink& link : index.links)
    out.verdicts.push_back({link.id, link.has_anchors ? LinkUse::used : LinkUse::no_anchor, 0});
  drop_surplus(index, config.links_per_anchor_pair, out.verdicts);
  out.pairs = pairs_of(index, out.verdicts);
  for (ChainPair& pair : out.pairs) {
    if (!pair.own()) continue;
    pair.verdict.links = static_cast<std::uint32_t>(pair.links.size());
    ChainFrames bent = frames;
    Groups groups = find_own_groups(index, config, pair, bent, out);
    weigh(index, bent, config, std::move(groups), pair);
    judge(config, pair);
    if (pair.joined()) frames = std::move(bent);
  }
  for (ChainPair& pair : out.pairs) {
    if (pair.own()) continue;
    const Links links = best_by_inliers(index, pair.links, config.links_compared);
    out.compared += pairs_among(links.size());
    pair.verdict.links = static_cast<std::uint32_t>(links.size());
    weigh(index, frames, config, find_groups(index, frames, config, links, false), pair);
    judge(config, pair);
  }
  doubt_triangles(index, frames, config, out.pairs);
  return out;
}

}  // namespace onemap::mapping
