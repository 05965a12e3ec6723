#include "mapping/team/needless_keyframes.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "mapping/team/candidates.hpp"
#include "mapping/team/way_on_map.hpp"

namespace onemap::mapping {

namespace {

constexpr std::chrono::seconds kAway{60};  // between two visits
constexpr double kNear_m = 0.3;
constexpr double kSameWay = 0.9396926;      // cosine of 20 degrees
constexpr std::uint32_t kFewestAlike = 12;  // features that are alike, as for a pair that is worth a look
constexpr std::size_t kMostAsked = 100;     // keyframes, of one look: each costs a question to the index

}  // namespace

std::vector<NeedlessKeyframes::View> NeedlessKeyframes::views(const TeamMember& own, const SolvedRobot& solved) {
  std::vector<View> out;
  for (const KeyframeOnMap& keyframe : keyframes_on_map(own, solved))
    if (own.keyframes[keyframe.position] != nullptr)
      out.push_back(
          {keyframe.position, own.keyframes.place(keyframe.position)->time, from_quantized(keyframe.T_map_keyframe)});
  return out;
}

// Of those that stay, the positions that saw before what this one sees.
std::set<std::uint32_t> NeedlessKeyframes::before(const View& view, const std::vector<View>& kept) {
  std::set<std::uint32_t> out;
  const Pose& here = view.T_map_keyframe;
  const auto saw_it = [&](const View& earlier) {
    return earlier.time + kAway <= view.time && (earlier.T_map_keyframe.t - here.t).norm() <= kNear_m &&
           rotation_cosine(here.R.transpose() * earlier.T_map_keyframe.R) >= kSameWay;
  };
  for (const View& earlier : kept)
    if (saw_it(earlier)) out.insert(static_cast<std::uint32_t>(earlier.position));
  return out;
}

bool NeedlessKeyframes::was_seen_before(const RecordPtr& record, const std::set<std::uint32_t>& before,
                                        PlaceIndex& index) {
  const auto keyframe = decode_keyframe(record->body);
  if (!keyframe) return false;
  const auto places = index.query(keyframe->descriptor_kind, binary_features(*keyframe), 1,
                                  [&](const PlaceId& id) { return before.contains(id.keyframe); });
  return !places.empty() && places.front().features >= kFewestAlike;
}

// The earliest first: what stays speaks for what goes.
std::vector<std::size_t> NeedlessKeyframes::look(const RobotId& self, const TeamMember& own, const SolvedRobot& solved,
                                                 OwnPlaces& places) {
  if (std::exchange(life_, own.incarnation) != own.incarnation) named_.clear(), tried_.clear();
  PlaceIndex& index = places.up_to_date(self, own);
  const auto is_gone = [&](std::size_t position) { return own.keyframes[position] == nullptr; };
  std::erase_if(named_, is_gone);
  std::erase_if(tried_, [&](const auto& tried) { return is_gone(tried.first); });
  std::vector<View> kept;
  std::vector<std::size_t> out;
  std::size_t asked = 0;
  for (const View& view : views(own, solved)) {
    if (named_.contains(view.position)) continue;
    const std::set<std::uint32_t> before = NeedlessKeyframes::before(view, kept);
    const bool asks = !before.empty() && !is_tried(view.position, before) && asked++ < kMostAsked;
    if (asks && was_seen_before(own.keyframes[view.position], before, index)) {
      out.push_back(view.position);
      continue;
    }
    if (asks) tried_[view.position] = {before.size(), *before.rbegin()};
    kept.push_back(view);
  }
  named_.insert(out.begin(), out.end());
  std::ranges::sort(out);
  return out;
}

bool NeedlessKeyframes::is_tried(std::size_t position, const std::set<std::uint32_t>& before) const {
  const auto tried = tried_.find(position);
  return tried != tried_.end() && tried->second == Tried{before.size(), *before.rbegin()};
}

KeyframeRecord place_alone(const KeyframeRecord& keyframe) {
  KeyframeRecord out;
  out.index = keyframe.index;
  out.time = keyframe.time;
  out.T_robot_keyframe = keyframe.T_robot_keyframe;
  out.anchor = keyframe.anchor;
  out.descriptor_kind = keyframe.descriptor_kind;
  return out;
}

}  // namespace onemap::mapping
