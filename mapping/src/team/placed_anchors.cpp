#include "mapping/team/placed_anchors.hpp"

#include <algorithm>
#include <iterator>

namespace onemap::mapping {

namespace {

// In the robot's own frame, sorted; of keyframes that claim one number the first counts.
std::vector<PlacedAnchor> own_anchors(const TeamMember& member, std::size_t keyframes) {
  std::vector<PlacedAnchor> out;
  for (const KeyframePlace& k : member.keyframes.places()) {
    if (k.position >= keyframes) break;
    if (k.index == k.anchor) out.push_back({k.index, k.T_robot_keyframe});
  }
  std::ranges::stable_sort(out, {}, &PlacedAnchor::keyframe);
  const auto same = [](const PlacedAnchor& a, const PlacedAnchor& b) { return a.keyframe == b.keyframe; };
  out.erase(std::unique(out.begin(), out.end(), same), out.end());
  return out;
}

// What the solution moves the surroundings of an anchor by: T_map_robot.
struct Bend {
  std::size_t anchor = 0;  // its position among the own ones
  Pose T_map_robot;
};

// At the anchor i; next: the first behind it.
Pose bend_at(const std::vector<Bend>& all, std::vector<Bend>::const_iterator next, std::size_t i) {
  if (next == all.begin()) return next->T_map_robot;
  const Bend& before = *std::prev(next);
  if (next == all.end()) return before.T_map_robot;
  const double share = static_cast<double>(i - before.anchor) / static_cast<double>(next->anchor - before.anchor);
  return between(before.T_map_robot, next->T_map_robot, share);
}

}  // namespace

Pose between(const Pose& a, const Pose& b, double share) {
  constexpr double kHardlyLessThanHalfATurn = -0.9;
  if (rotation_cosine(a.R.transpose() * b.R) < kHardlyLessThanHalfATurn) return share < 0.5 ? a : b;
  Pose out;
  for (int i = 0; i < 3; ++i) {  // scalars: where anchors are decides the map's bytes
    out.t[i] = (1 - share) * a.t[i] + share * b.t[i];
    for (int j = 0; j < 3; ++j) out.R(i, j) = (1 - share) * a.R(i, j) + share * b.R(i, j);
  }
  out.R = orthonormal(out.R);
  return out;
}

std::vector<PlacedAnchor> placed_anchors(const TeamMember& member, const SolvedRobot& solved, std::size_t keyframes) {
  if (member.incarnation != solved.chain.incarnation) return {};
  std::vector<PlacedAnchor> out = own_anchors(member, keyframes);
  std::vector<Bend> bends;  // of those that the solution has
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto at = std::ranges::lower_bound(solved.anchors, out[i].keyframe, {}, &PlacedAnchor::keyframe);
    if (at == solved.anchors.end() || at->keyframe != out[i].keyframe) continue;
    bends.push_back({i, from_quantized(at->T_map_anchor) * from_quantized(out[i].T_map_anchor).inverse()});
    out[i] = *at;
  }
  if (bends.empty()) return out;
  auto next = bends.begin();
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (next != bends.end() && next->anchor == i) {
      ++next;
      continue;
    }
    out[i].T_map_anchor = quantize(bend_at(bends, next, i) * from_quantized(out[i].T_map_anchor));
  }
  return out;
}

const SolvedRobot* find_solved(const SolutionRecord& solution, const ChainId& chain) {
  const auto at = std::ranges::lower_bound(solution.robots, chain, {}, &SolvedRobot::chain);
  return at != solution.robots.end() && at->chain == chain ? &*at : nullptr;
}

}  // namespace onemap::mapping
