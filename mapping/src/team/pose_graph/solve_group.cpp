#include "solve_group.hpp"

#include <algorithm>

#include "gnc.hpp"

namespace onemap::mapping {

namespace {

constexpr std::uint32_t kFirstSteps = 30;

bool may_count(const LinkVerdict& verdict) {
  return verdict.use == LinkUse::used || verdict.use == LinkUse::contradicts_chain;
}

void collect(const GraphIndex& index, const Joining& joining, SolvedGroup& out) {
  const std::vector<std::size_t>& chains = out.group.chains;
  const auto in_group = [&](std::size_t chain) { return std::binary_search(chains.begin(), chains.end(), chain); };
  for (std::size_t chain : chains)
    for (std::size_t i = 0; i < index.chains[chain].count; ++i) out.anchors.push_back(index.chains[chain].first + i);
  for (std::size_t i = 0; i < index.links.size(); ++i)
    if (may_count(joining.verdicts[i]) && in_group(index.links[i].chain_a) && in_group(index.links[i].chain_b))
      out.links.push_back(i);
}

PoseProblem problem_of(const GraphIndex& index, const SolvedGroup& group, std::vector<Pose> start) {
  const auto place = [&](std::size_t anchor) {
    return static_cast<std::size_t>(std::lower_bound(group.anchors.begin(), group.anchors.end(), anchor) -
                                    group.anchors.begin());
  };
  PoseProblem out{.poses = std::move(start), .fixed = place(group.reference)};
  const auto add = [&](GraphEdge edge, std::vector<GraphEdge>& to) {
    edge.a = place(edge.a);
    edge.b = place(edge.b);
    to.push_back(std::move(edge));
  };
  for (std::size_t anchor : group.anchors)
    if (anchor != index.first_of_chain(anchor)) add(odometry_edge(index, anchor), out.odometry);
  for (std::size_t link : group.links) add(index.links[link].edge, out.links);
  return out;
}

// Weights to start from, of the links of one group.
class Start {
 public:
  Start(const Joining& joining, const InUse& in_use, const SolvedGroup& group)
      : joining_(joining), in_use_(in_use), group_(group), weights_(group.links.size()) {
    for (std::size_t i = 0; i < weights_.size(); ++i)
      if (in_use.links[group.links[i]] == InUse::Link::used) weights_[i] = 1;
  }

  std::size_t place(std::size_t link) const {
    return static_cast<std::size_t>(std::lower_bound(group_.links.begin(), group_.links.end(), link) -
                                    group_.links.begin());
  }
  // The links of the pair that agree count, but for those that were dropped before. True: some did not yet.
  bool trust(const ChainPair& pair) {
    bool more = false;
    for (std::size_t link : pair.agreeing)
      if (double& weight = weights_[place(link)]; weight < 1 && in_use_.links[link] != InUse::Link::dropped)
        weight = 1, more = true;
    return more;
  }
  // What holds the group together, and own loops.
  void trust_tree() {
    for (std::size_t pair : tree_and_loops()) trust(joining_.pairs[pair]);
  }
  // Where the poses as they are fit what holds the group together, pairs that close a ring and fit them too contradict
  // nothing, and count. Gives the other ones.
  std::vector<std::size_t> trust_rings_that_fit(const std::vector<double>& squared_errors, double barc2) {
    std::vector<std::size_t> open;
    bool sound = true;
    for (std::size_t pair : tree_and_loops()) sound &= fits(joining_.pairs[pair], squared_errors, barc2);
    for (std::size_t pair : group_.group.rings)
      if (sound && fits(joining_.pairs[pair], squared_errors, barc2))
        trust(joining_.pairs[pair]);
      else
        open.push_back(pair);
    return open;
  }
  // Those of them that the rest does not speak against. True: some that did not count yet.
  bool trust_rings(const std::vector<std::size_t>& rings, const LeastSquares& squares, double chi2) {
    std::vector<std::size_t> fit;
    for (std::size_t pair : rings)
      if (const auto surprise = squares.surprise(place(joining_.pairs[pair].best)); surprise && *surprise <= chi2)
        fit.push_back(pair);
    bool more = false;
    for (std::size_t pair : fit) more |= trust(joining_.pairs[pair]);
    return more;
  }
  std::vector<double>& weights() { return weights_; }

 private:
  std::vector<std::size_t> tree_and_loops() const {
    std::vector<std::size_t> out = group_.group.tree;
    for (std::size_t i = 0; i < joining_.pairs.size(); ++i)
      if (const ChainPair& pair = joining_.pairs[i];
          pair.own() && pair.joined() && std::ranges::binary_search(group_.group.chains, pair.chain_a))
        out.push_back(i);
    return out;
  }
  // Three in four of the links that agree: one in a hundred misses by chance.
  bool fits(const ChainPair& pair, const std::vector<double>& squared_errors, double barc2) const {
    const auto within =
        std::ranges::count_if(pair.agreeing, [&](std::size_t link) { return squared_errors[place(link)] <= barc2; });
    return 4 * static_cast<std::size_t>(within) >= 3 * pair.agreeing.size();
  }

  const Joining& joining_;
  const InUse& in_use_;
  const SolvedGroup& group_;
  std::vector<double> weights_;
};

}  // namespace

SolvedGroup solve_group(const GraphIndex& index, const ChainFrames& frames, const ChainGroup& group,
                        const Joining& joining, const InUse& in_use, const PoseGraphConfig& config,
                        SolveEffort& effort) {
  SolvedGroup out{.group = group, .reference = reference_of(index, group, joining, in_use)};
  collect(index, joining, out);
  PoseProblem problem = problem_of(index, out, start_poses(index, frames, group, joining, in_use, out.reference));
  LeastSquares squares(problem, effort);
  Start start(joining, in_use, out);
  start.trust_tree();
  const std::vector<std::size_t> rings = start.trust_rings_that_fit(squares.squared_errors(), config.gnc.barc2);
  if (rings.empty()) squares.no_more_surprises();
  squares.optimise(start.weights(), kFirstSteps);
  const bool more = start.trust_rings(rings, squares, config.join.chi2);
  squares.no_more_surprises();
  if (more) squares.optimise(start.weights(), kFirstSteps);
  std::vector<InUse::Link> history;
  for (std::size_t link : out.links) history.push_back(in_use.links[link]);
  const bool warm = in_use.anchors[out.reference].has_value();
  effort.converged &= solve_graduated(squares, start.weights(), history, config.gnc, warm, effort);
  for (double weight : start.weights()) out.used.push_back(weight > 0);
  out.squared_errors = squares.squared_errors();
  out.poses = std::move(problem.poses);
  return out;
}

}  // namespace onemap::mapping
