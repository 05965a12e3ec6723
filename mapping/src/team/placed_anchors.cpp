#include "mapping/team/placed_anchors.hpp"

#include <algorithm>

namespace onemap::mapping {

namespace {

// In the robot's own frame, sorted; of keyframes that claim one number the first counts.
std::vector<PlacedAnchor> own_anchors(const TeamMember& member, std::size_t keyframes) {
  std::vector<PlacedAnchor> out;
  const std::vector<KeyframePlace>& places = member.keyframes.places();
  for (const KeyframePlace& k : std::span(places).first(std::min(keyframes, places.size())))
    if (k.index == k.anchor) out.push_back({k.index, k.T_robot_keyframe});
  std::ranges::stable_sort(out, {}, &PlacedAnchor::keyframe);
  const auto same = [](const PlacedAnchor& a, const PlacedAnchor& b) { return a.keyframe == b.keyframe; };
  out.erase(std::unique(out.begin(), out.end(), same), out.end());
  return out;
}

}  // namespace

std::vector<PlacedAnchor> placed_anchors(const TeamMember& member, const SolvedRobot& solved, std::size_t keyframes) {
  if (member.incarnation != solved.chain.incarnation) return {};
  std::vector<PlacedAnchor> out = own_anchors(member, keyframes);
  const std::vector<PlacedAnchor> own = out;
  std::optional<Pose> T_map_robot;  // by the last anchor that the solution has
  std::size_t first_solved = out.size();
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto at = std::ranges::lower_bound(solved.anchors, out[i].keyframe, {}, &PlacedAnchor::keyframe);
    if (at != solved.anchors.end() && at->keyframe == out[i].keyframe) {
      out[i] = *at;
      T_map_robot = from_quantized(at->T_map_anchor) * from_quantized(own[i].T_map_anchor).inverse();
      first_solved = std::min(first_solved, i);
    } else if (T_map_robot) {
      out[i].T_map_anchor = quantize(*T_map_robot * from_quantized(own[i].T_map_anchor));
    }
  }
  if (first_solved == out.size()) return out;
  const Pose T_first =
      from_quantized(out[first_solved].T_map_anchor) * from_quantized(own[first_solved].T_map_anchor).inverse();
  for (std::size_t i = 0; i < first_solved; ++i)
    out[i].T_map_anchor = quantize(T_first * from_quantized(own[i].T_map_anchor));
  return out;
}

const SolvedRobot* find_solved(const SolutionRecord& solution, const ChainId& chain) {
  const auto at = std::ranges::lower_bound(solution.robots, chain, {}, &SolvedRobot::chain);
  return at != solution.robots.end() && at->chain == chain ? &*at : nullptr;
}

}  // namespace onemap::mapping
