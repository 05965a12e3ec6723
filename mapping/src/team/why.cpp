#include "mapping/team/why.hpp"

#include <algorithm>
#include <utility>

#include "mapping/team/link_table.hpp"
#include "mapping/team/placed_anchors.hpp"
#include "mapping/team/team_graph.hpp"

namespace onemap::mapping {

namespace {

const LinkRecord* link_of(const TeamLog& log, const ChainId& a, const ChainId& b) {
  if (a != b) return link_between(log, a, b);
  const TeamMember* member = log.find(a);
  return member != nullptr ? own_loops(*member, a.robot) : nullptr;
}

std::pair<ChainId, ChainId> chains_of(const LinkVerdict& link) { return std::minmax(link.id.a.chain, link.id.b.chain); }

void add_graph(const GraphSolution& solution, WhyPair& pair) {
  for (const PairVerdict& verdict : solution.pairs)
    if (verdict.a == pair.a && verdict.b == pair.b) pair.verdict = verdict;
  for (const LinkVerdict& link : solution.links) {
    if (chains_of(link) != std::pair{pair.a, pair.b}) continue;
    ++pair.pairs[link.use];
    if (link.use == LinkUse::used) pair.worst = std::max(pair.worst, link.number);
  }
}

std::optional<WhyPair> why_pair(const TeamLog& log, const GraphSolution& solution, const ChainId& a, const ChainId& b) {
  WhyPair out;
  std::tie(out.a, out.b) = std::minmax(a, b);
  if (const LinkRecord* link = link_of(log, out.a, out.b)) out.link = *link;
  if (const auto* ruling = log.rulings().find(out.a, out.b)) out.ruling = *ruling;
  if (!out.link && !out.ruling) return std::nullopt;
  out.verdict.a = out.a;
  out.verdict.b = out.b;
  add_graph(solution, out);
  return out;
}

// The shortest over pairs that links in use join; empty: there is none.
std::vector<ChainId> shortest_way(const GraphSolution& solution, const ChainId& from, const ChainId& to) {
  std::map<ChainId, ChainId> came_from{{from, from}};
  std::vector<ChainId> seen{from};
  for (std::size_t i = 0; i < seen.size() && !came_from.contains(to); ++i) {
    const ChainId here = seen[i];
    for (const PairVerdict& pair : solution.pairs) {
      if (pair.used == 0 || (pair.a != here && pair.b != here)) continue;
      const ChainId& next = pair.a == here ? pair.b : pair.a;
      if (came_from.emplace(next, here).second) seen.push_back(next);
    }
  }
  std::vector<ChainId> way;
  if (!came_from.contains(to)) return way;
  for (ChainId at = to; at != from; at = came_from.at(at)) way.push_back(at);
  way.push_back(from);
  std::ranges::reverse(way);
  return way;
}

}  // namespace

Why why(const TeamLog& log, const SolutionRecord* in_use, const RobotId& a, const RobotId& b) {
  const GraphSolution solution = solve_graph(log, in_use);
  Why out;
  std::map<std::pair<ChainId, ChainId>, WhyPair> pairs;
  for (const ChainId& of_a : log.chains())
    for (const ChainId& of_b : log.chains())
      if (of_a.robot == a && of_b.robot == b)
        if (auto pair = why_pair(log, solution, of_a, of_b)) pairs.emplace(std::pair{pair->a, pair->b}, *pair);
  for (auto& [chains, pair] : pairs) out.pairs.push_back(std::move(pair));
  const ChainId now_a = log.present(a), now_b = log.present(b);
  out.one_map = in_use != nullptr && find_solved(*in_use, now_a) != nullptr && find_solved(*in_use, now_b) != nullptr;
  if (out.one_map) out.way = shortest_way(solution, now_a, now_b);
  return out;
}

}  // namespace onemap::mapping
