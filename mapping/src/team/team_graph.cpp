#include "mapping/team/team_graph.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <span>

#include "mapping/team/link_table.hpp"
#include "mapping/team/placed_anchors.hpp"
#include "mapping/team/pose_graph_g2o.hpp"
#include "team/pose_graph/keep.hpp"
#include "team/pose_graph/se3.hpp"

namespace onemap::mapping {

namespace {

// How unsure odometry is of the step from one keyframe to the next; the errors of steps are independent.
constexpr double kStep_m = 0.005, kStep_rad = 0.004;
constexpr double kBox_m = 1.5;  // what an anchor's submap reaches: a box of three metres in front of it

// The keyframes of one robot, sorted by their numbers.
using Places = std::vector<KeyframePlace>;

const KeyframePlace* find_place(const Places& places, std::uint32_t keyframe) {
  const auto at = std::ranges::lower_bound(places, keyframe, {}, &KeyframePlace::index);
  return at != places.end() && at->index == keyframe ? &*at : nullptr;
}

ChainAnchor surroundings() {
  ChainAnchor out;
  out.box_centre_m = Vector3d(0, 0, kBox_m);
  out.box_half_m = Vector3d::Constant(kBox_m);
  return out;
}

// The errors of the steps from one anchor of the graph to the next, at the right of the last one's pose. In one go they
// are as sure in all directions; with anchors between that are left out a turn at one of these is a way to the side
// here.
class Steps {
 public:
  void step() { ++count_; }
  // The way goes on from an anchor that is left out.
  void pass(const Pose& T_robot_passed) {
    const Matrix6d here = covariance(T_robot_passed);
    passed_ = Passed{here, T_robot_passed};
    count_ = 0;
  }
  Matrix6d information(const Pose& T_robot_here) const {
    return passed_ ? covariance(T_robot_here).inverse().eval() : own_information();
  }
  void begin() { *this = {}; }

 private:
  struct Passed {
    Matrix6d covariance;
    Pose T_robot_passed;
  };
  Matrix6d own_information() const {
    return information_of(kStep_rad * std::sqrt(count_), kStep_m * std::sqrt(count_));
  }
  Matrix6d covariance(const Pose& T_robot_here) const {
    Matrix6d out = Matrix6d::Zero();
    for (int i = 0; i < 6; ++i) out(i, i) = count_ * (i < 3 ? kStep_rad * kStep_rad : kStep_m * kStep_m);
    if (!passed_) return out;
    const Matrix6d lever = adjoint(T_robot_here.inverse() * passed_->T_robot_passed);
    return out + lever * passed_->covariance * lever.transpose();
  }

  double count_ = 0;
  std::optional<Passed> passed_;
};

std::vector<ChainAnchor> chain_of(const Places& places, const std::set<std::uint32_t>& bare) {
  std::vector<ChainAnchor> out;
  Pose T_robot_previous;
  Steps steps;
  for (const KeyframePlace& place : places) {
    steps.step();
    if (place.index != place.anchor) continue;
    const Pose T_robot_anchor = from_quantized(place.T_robot_keyframe);
    if (!out.empty() && bare.contains(place.index)) {
      steps.pass(T_robot_anchor);
      continue;
    }
    ChainAnchor anchor = surroundings();
    anchor.keyframe = place.index;
    anchor.T_previous_anchor = T_robot_previous.inverse() * T_robot_anchor;
    anchor.information = steps.information(T_robot_anchor);
    out.push_back(anchor);
    T_robot_previous = T_robot_anchor;
    steps.begin();
  }
  return out;
}

// Anchors that nothing hangs on any more: what was seen there is somebody else's by now, no keyframe and no voxels are
// left, and no link. The graph does without them, so that it grows with the area and not with the time.
std::set<std::uint32_t> bare_anchors(const TeamMember& member) {
  std::set<std::uint32_t> out;
  for (const KeyframePlace& place : member.keyframes.places())
    if (place.gone && place.index == place.anchor) out.insert(place.index);
  if (out.empty()) return out;
  for (const KeyframePlace& place : member.keyframes.places())
    if (!place.gone) out.erase(place.anchor);
  member.submaps.for_each_of(member.submaps.size(), [&](const SubmapPlace& place) { out.erase(place.anchor); });
  return out;
}

std::optional<LinkEnd> end_of(const ChainId& chain, const Places& places, std::uint32_t keyframe) {
  const KeyframePlace* place = find_place(places, keyframe);
  const KeyframePlace* anchor = place != nullptr ? find_place(places, place->anchor) : nullptr;
  if (anchor == nullptr || anchor->anchor != anchor->index) return std::nullopt;
  const Pose T_robot_anchor = from_quantized(anchor->T_robot_keyframe);
  return LinkEnd{chain, keyframe, anchor->index, T_robot_anchor.inverse() * from_quantized(place->T_robot_keyframe)};
}

struct Chain {
  ChainId id;
  Places places;
  const KeyframeLog* log = nullptr;
  std::set<std::uint32_t> bare;  // anchors that the graph does without
};

// The last one among the first so many records of the log.
std::uint32_t last_known(const Chain& chain, std::uint32_t count) {
  if (count == 0 || count >= chain.log->size()) return kAllKeyframes;
  std::uint32_t last = 0;
  for (const KeyframePlace& place : chain.log->places())
    if (place.position < count) last = std::max(last, place.index);
  return last;
}

void take_link(const LinkRecord& link, const Chain& a, const Chain& b, std::vector<GraphLink>& out) {
  const std::uint32_t known_a = last_known(a, link.keyframes_a), known_b = last_known(b, link.keyframes_b);
  for (const LinkPair& pair : link.pairs) {
    const auto end_a = end_of(a.id, a.places, pair.keyframe_a), end_b = end_of(b.id, b.places, pair.keyframe_b);
    if (!end_a || !end_b || end_a->anchor_id() == end_b->anchor_id()) continue;
    out.push_back({*end_a, *end_b, from_quantized(pair.T_a_b), pair.inliers, known_a, known_b});
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
  for (const ChainId& life : lives)
    if (const TeamMember* member = log.find(life); member != nullptr)
      chains.emplace(life, Chain{life, member->keyframes.chain(), &member->keyframes, bare_anchors(*member)});
  std::vector<GraphLink> links;
  for (const std::vector<TeamLink>& from : {counting_links(log), counting_loops(log)})
    for (const TeamLink& link : from)
      if (const auto a = chains.find(link.a), b = chains.find(link.b); a != chains.end() && b != chains.end())
        take_link(*link.link, a->second, b->second, links);
  for (const GraphLink& link : links)
    for (const LinkEnd& end : {link.a, link.b}) chains.at(end.chain).bare.erase(end.anchor);
  for (const auto& [life, chain] : chains)
    if (auto anchors = chain_of(chain.places, chain.bare); !anchors.empty())
      static_cast<void>(graph.set_chain(life, std::move(anchors)));
  for (const GraphLink& link : links) static_cast<void>(graph.set_link(link));  // what is refused the graph counts
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

namespace {
bool has_anchor(const SolvedRobot& solved, std::uint32_t keyframe) {
  const auto at = std::ranges::lower_bound(solved.anchors, keyframe, {}, &PlacedAnchor::keyframe);
  return at != solved.anchors.end() && at->keyframe == keyframe;
}
}  // namespace

bool agree(const TeamLog& log, const SolutionRecord& a, const SolutionRecord& b, double bound_m) {
  if (a.reference != b.reference || a.robots.size() != b.robots.size()) return false;
  const ChainAnchor box = surroundings();
  for (std::size_t i = 0; i < a.robots.size(); ++i) {
    if (a.robots[i].chain != b.robots[i].chain) return false;
    const TeamMember* member = log.find(a.robots[i].chain);
    if (member == nullptr) return false;
    const auto in_a = placed_anchors(*member, a.robots[i]), in_b = placed_anchors(*member, b.robots[i]);
    for (std::size_t k = 0; k < in_a.size(); ++k)
      if (has_anchor(b.robots[i], in_b[k].keyframe) &&
          box_moved(box, from_quantized(in_a[k].T_map_anchor), from_quantized(in_b[k].T_map_anchor), bound_m))
        return false;
  }
  return true;
}

}  // namespace onemap::mapping
