#include "mapping/team/team_graph.hpp"

#include <algorithm>
#include <map>
#include <span>

#include "mapping/team/link_table.hpp"
#include "mapping/team/placed_anchors.hpp"
#include "mapping/team/pose_graph_g2o.hpp"
#include "team/pose_graph/keep.hpp"

namespace onemap::mapping {

namespace {

// How unsure odometry is of the step from one keyframe to the next; the errors of steps are independent.
constexpr double kStep_m = 0.005, kStep_rad = 0.004;
constexpr double kBox_m = 1.5;  // what an anchor's submap reaches: a box of three metres in front of it

// The keyframes of one robot by their numbers; of those that claim one number the first counts.
using Places = std::map<std::uint32_t, const KeyframePlace*>;

Places places_of(const TeamMember& member) {
  Places out;
  for (const KeyframePlace& place : member.keyframes.places())
    if (place.known()) out.emplace(place.index, &place);
  return out;
}

ChainAnchor surroundings() {
  ChainAnchor out;
  out.box_centre_m = Vector3d(0, 0, kBox_m);
  out.box_half_m = Vector3d::Constant(kBox_m);
  return out;
}

std::vector<ChainAnchor> chain_of(const Places& places) {
  std::vector<ChainAnchor> out;
  Pose T_robot_previous;
  double steps = 0;
  for (const auto& [index, place] : places) {
    ++steps;
    if (index != place->anchor) continue;
    const Pose T_robot_anchor = from_quantized(place->T_robot_keyframe);
    ChainAnchor anchor = surroundings();
    anchor.keyframe = index;
    anchor.T_previous_anchor = T_robot_previous.inverse() * T_robot_anchor;
    anchor.information = information_of(kStep_rad * std::sqrt(steps), kStep_m * std::sqrt(steps));
    out.push_back(anchor);
    T_robot_previous = T_robot_anchor;
    steps = 0;
  }
  return out;
}

std::optional<LinkEnd> end_of(const ChainId& chain, const Places& places, std::uint32_t keyframe) {
  const auto at = places.find(keyframe);
  if (at == places.end()) return std::nullopt;
  const auto anchor = places.find(at->second->anchor);
  if (anchor == places.end() || anchor->second->anchor != anchor->first) return std::nullopt;
  const Pose T_robot_anchor = from_quantized(anchor->second->T_robot_keyframe);
  return LinkEnd{chain, keyframe, anchor->first,
                 T_robot_anchor.inverse() * from_quantized(at->second->T_robot_keyframe)};
}

struct Chain {
  ChainId id;
  Places places;
  std::span<const KeyframePlace> in_order;  // of the log
};

// The last one among the first so many records of the log.
std::uint32_t last_known(const Chain& chain, std::uint32_t count) {
  if (count == 0 || count >= chain.in_order.size()) return kAllKeyframes;
  std::uint32_t last = 0;
  for (const KeyframePlace& place : chain.in_order.first(count))
    if (place.known()) last = std::max(last, place.index);
  return last;
}

void add_link(const LinkRecord& link, const Chain& a, const Chain& b, PoseGraph& graph) {
  const std::uint32_t known_a = last_known(a, link.keyframes_a), known_b = last_known(b, link.keyframes_b);
  for (const LinkPair& pair : link.pairs) {
    const auto end_a = end_of(a.id, a.places, pair.keyframe_a), end_b = end_of(b.id, b.places, pair.keyframe_b);
    if (!end_a || !end_b || end_a->anchor_id() == end_b->anchor_id()) continue;
    // What is refused the graph counts.
    static_cast<void>(graph.set_link({*end_a, *end_b, from_quantized(pair.T_a_b), pair.inliers, known_a, known_b}));
  }
}

// The solution in use as the graph has it: one component, of the anchors that are here.
GraphSolution graph_solution(const TeamLog& log, const SolutionRecord& solution) {
  GraphSolution out;
  GraphComponent& component = out.components.emplace_back();
  for (const SolvedRobot& solved : solution.robots) {
    const TeamMember* member = log.find(solved.chain);
    if (member == nullptr) continue;
    const ChainId& chain = solved.chain;
    component.chains.push_back(chain);
    const auto anchors = placed_anchors(*member, solved);
    if (chain == solution.reference && !anchors.empty()) component.reference = {chain, anchors[0].keyframe};
    for (const PlacedAnchor& anchor : anchors)
      out.anchors.push_back({.id = {chain, anchor.keyframe}, .T_map_anchor = anchor.T_map_anchor});
  }
  return out;
}

// The global frame is that of the reference's odometry; another one is nobody's to choose.
bool in_own_frame(const TeamLog& log, const SolutionRecord& solution) {
  const TeamMember* member = log.find(solution.reference);
  const SolvedRobot* solved = find_solved(solution, solution.reference);
  if (member == nullptr || solved == nullptr) return false;
  const auto here = placed_anchors(*member, *solved), own = placed_anchors(*member, {solved->chain, {}});
  return !here.empty() && here[0] == own[0];
}

SolutionRecord record_of(const GraphSolution& solution) {
  SolutionRecord out;
  out.reference = solution.components[0].reference.chain;
  for (const SolvedAnchor& anchor : solution.anchors) {
    if (anchor.component != 0) continue;
    const ChainId& chain = anchor.id.chain;
    if (out.robots.empty() || out.robots.back().chain != chain) out.robots.push_back({chain, {}});
    out.robots.back().anchors.push_back({anchor.id.keyframe, anchor.T_map_anchor});
  }
  for (const LinkVerdict& link : solution.links) (link.use == LinkUse::used ? out.links_used : out.links_refused) += 1;
  return out;
}

GraphSolution solve_from(const PoseGraph& graph, const TeamLog& log, const SolutionRecord* in_use) {
  if (in_use == nullptr || !in_own_frame(log, *in_use)) return graph.solve();
  const GraphSolution before = graph_solution(log, *in_use);
  return graph.solve(&before);
}

}  // namespace

PoseGraph team_graph(const TeamLog& log, std::span<const ChainId> lives) {
  PoseGraph graph;
  std::map<ChainId, Chain> chains;
  for (const ChainId& life : lives) {
    const TeamMember* member = log.find(life);
    if (member == nullptr) continue;
    Chain chain{life, places_of(*member), member->keyframes.places()};
    if (auto anchors = chain_of(chain.places); !anchors.empty() && graph.set_chain(life, std::move(anchors)))
      chains.emplace(life, std::move(chain));
  }
  for (const std::vector<TeamLink>& links : {counting_links(log), counting_loops(log)})
    for (const TeamLink& link : links)
      if (const auto a = chains.find(link.a), b = chains.find(link.b); a != chains.end() && b != chains.end())
        add_link(*link.link, a->second, b->second, graph);
  return graph;
}

SolutionRecord solve_team(const TeamLog& log, std::span<const ChainId> lives, const SolutionRecord* in_use) {
  const PoseGraph graph = team_graph(log, lives);
  if (graph.chains().empty()) {
    if (lives.empty()) return {};
    return alone_on_map(*std::ranges::min_element(lives));
  }
  return record_of(solve_from(graph, log, in_use));
}

GraphSolution solve_graph(const TeamLog& log, const SolutionRecord* in_use) {
  return solve_from(team_graph(log, log.chains()), log, in_use);
}

std::string graph_text(const TeamLog& log, const SolutionRecord& in_use) {
  const PoseGraph graph = team_graph(log, log.chains());
  return to_g2o(graph, solve_from(graph, log, &in_use));
}

bool agree(const TeamLog& log, const SolutionRecord& a, const SolutionRecord& b, double bound_m) {
  if (a.reference != b.reference || a.robots.size() != b.robots.size()) return false;
  const ChainAnchor box = surroundings();
  for (std::size_t i = 0; i < a.robots.size(); ++i) {
    if (a.robots[i].chain != b.robots[i].chain) return false;
    const TeamMember* member = log.find(a.robots[i].chain);
    if (member == nullptr) return false;
    const auto in_a = placed_anchors(*member, a.robots[i]), in_b = placed_anchors(*member, b.robots[i]);
    for (std::size_t k = 0; k < in_a.size() && k < in_b.size(); ++k)
      if (box_moved(box, from_quantized(in_a[k].T_map_anchor), from_quantized(in_b[k].T_map_anchor), bound_m))
        return false;
  }
  return true;
}

}  // namespace onemap::mapping
