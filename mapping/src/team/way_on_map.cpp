#include "mapping/team/way_on_map.hpp"

#include <algorithm>

namespace onemap::mapping {

namespace {

// The correction of the anchor; of an anchor that the map does not have, that of the one before it.
const Pose& correction_of(const std::vector<AnchorCorrection>& all, std::uint32_t anchor) {
  const auto after = std::ranges::upper_bound(all, anchor, {}, &AnchorCorrection::anchor);
  return (after == all.begin() ? *after : *std::prev(after)).T_map_robot;
}

QuantizedPose moved(const Pose& T_map_robot, const QuantizedPose& T_robot_any) {
  return quantize(T_map_robot * from_quantized(T_robot_any));
}

}  // namespace

std::vector<AnchorCorrection> corrections(const TeamMember& member, std::span<const PlacedAnchor> anchors) {
  std::vector<AnchorCorrection> out;
  for (const KeyframePlace& k : member.places) {
    if (k.index != k.anchor) continue;
    const auto at = std::ranges::lower_bound(anchors, k.index, {}, &PlacedAnchor::keyframe);
    if (at == anchors.end() || at->keyframe != k.index) continue;
    out.push_back({k.index, from_quantized(at->T_map_anchor) * from_quantized(k.T_robot_keyframe).inverse()});
  }
  std::ranges::stable_sort(out, {}, &AnchorCorrection::anchor);
  return out;
}

std::vector<StampedPose> way_on_map(const TeamMember& member, std::span<const PlacedAnchor> anchors) {
  const std::vector<AnchorCorrection> all = corrections(member, anchors);
  if (all.empty()) return {};
  std::vector<StampedPose> way = member.trajectory();
  std::size_t next = 0;  // keyframe
  for (StampedPose& pose : way) {
    while (next < member.places.size() && member.places[next].time <= pose.time) ++next;
    const std::uint32_t anchor = next == 0 ? 0 : member.places[next - 1].anchor;
    pose.T_robot_camera = moved(correction_of(all, anchor), pose.T_robot_camera);
  }
  return way;
}

std::vector<QuantizedPose> keyframes_on_map(const TeamMember& member, std::span<const PlacedAnchor> anchors) {
  const std::vector<AnchorCorrection> all = corrections(member, anchors);
  std::vector<QuantizedPose> out;
  if (all.empty()) return out;
  for (const KeyframePlace& k : member.places) out.push_back(moved(correction_of(all, k.anchor), k.T_robot_keyframe));
  return out;
}

}  // namespace onemap::mapping
