#include "mapping/team/way_on_map.hpp"

#include <algorithm>
#include <map>

#include "mapping/team/placed_anchors.hpp"

namespace onemap::mapping {

namespace {

// What each anchor moves its surroundings by: T_map_robot.
using Bends = std::map<std::uint32_t, Pose>;

Bends bends(const TeamMember& member, const SolvedRobot& solved) {
  const auto own = placed_anchors(member, {solved.chain, {}}), placed = placed_anchors(member, solved);
  Bends out;
  for (std::size_t i = 0; i < own.size(); ++i)
    out[own[i].keyframe] = from_quantized(placed[i].T_map_anchor) * from_quantized(own[i].T_map_anchor).inverse();
  return out;
}

// Of an anchor that is not known, that of the one before it.
const Pose& bend_at(const Bends& all, std::uint32_t anchor) {
  const auto after = all.upper_bound(anchor);
  return (after == all.begin() ? after : std::prev(after))->second;
}

// How far `time` is from the one to the other, 0 to 1.
double share_of(FrameTime from, FrameTime to, FrameTime time) {
  const double all = to_seconds(to - from), part = to_seconds(time - from);
  return all > 0 ? std::clamp(part / all, 0.0, 1.0) : 0;
}

}  // namespace

std::vector<StampedPose> way_on_map(const TeamMember& member, const SolvedRobot& solved) {
  const Bends all = bends(member, solved);
  if (all.empty()) return {};
  std::vector<StampedPose> way = member.trajectory.poses();
  const std::vector<KeyframePlace> places = member.keyframes.chain();
  std::size_t next = 0;  // the first keyframe after the pose
  for (StampedPose& pose : way) {
    while (next < places.size() && places[next].time <= pose.time) ++next;
    const std::size_t before = next == 0 ? 0 : next - 1, after = std::min(next, places.size() - 1);
    const Pose& here = bend_at(all, places[before].anchor);
    const Pose T_robot_camera = from_quantized(pose.T_robot_camera);
    Pose moved = here * T_robot_camera;
    if (places[before].anchor != places[after].anchor)
      moved = between(moved, bend_at(all, places[after].anchor) * T_robot_camera,
                      share_of(places[before].time, places[after].time, pose.time));
    pose.T_robot_camera = quantize(moved);
  }
  return way;
}

std::vector<KeyframeOnMap> keyframes_on_map(const TeamMember& member, const SolvedRobot& solved) {
  const Bends all = bends(member, solved);
  std::vector<KeyframeOnMap> out;
  if (all.empty()) return out;
  out.reserve(member.keyframes.places().size());
  for (const KeyframePlace& place : member.keyframes.places())
    out.push_back({place.position, quantize(bend_at(all, place.anchor) * from_quantized(place.T_robot_keyframe))});
  return out;
}

QuantizedPose correction_now(const TeamMember& member, const SolvedRobot& solved) {
  const Bends all = bends(member, solved);
  return all.empty() ? QuantizedPose{} : quantize(all.rbegin()->second);
}

}  // namespace onemap::mapping
