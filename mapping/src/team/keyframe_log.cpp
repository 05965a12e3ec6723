#include "mapping/team/keyframe_log.hpp"

#include <algorithm>
#include <utility>

#include "mapping/records/keyframe.hpp"

namespace onemap::mapping {

Status KeyframeLog::add(const RecordPtr& record) {
  if (places_.size() == kMost) return Error{"keyframe record", "this robot has as many as are looked at"};
  const std::size_t position = places_.size();
  sequences_.push_back(record->id.seq);
  places_.emplace_back();
  if (record->dropped) {
    gaps_.push_back(static_cast<std::uint32_t>(position));
    return success();
  }
  const auto keyframe = decode_keyframe(record->body);
  if (!keyframe) return keyframe.error();
  const KeyframePlace place{keyframe->index, keyframe->anchor, keyframe->T_robot_keyframe, keyframe->time};
  if (!keyframe->features.empty() || keyframe->grid.width > 0) {
    views_.push_back({static_cast<std::uint32_t>(position), record});
    places_.back() = place;
    return success();
  }
  const std::size_t earlier = position_of(record->seal.replaces, position);
  if (earlier == position)
    places_.back() = place;
  else
    replace(earlier, place);
  return success();
}

std::size_t KeyframeLog::position_of(std::uint32_t sequence, std::size_t before) const {
  const auto end = sequences_.begin() + static_cast<std::ptrdiff_t>(before);
  const auto at = std::lower_bound(sequences_.begin(), end, sequence);
  return at != end && *at == sequence ? static_cast<std::size_t>(at - sequences_.begin()) : before;
}

void KeyframeLog::replace(std::size_t position, const KeyframePlace& place) {
  places_[position] = place;
  std::erase(gaps_, position);
  if (std::ranges::find(replaced_, position) == replaced_.end())
    replaced_.push_back(static_cast<std::uint32_t>(position));
  const auto view = std::ranges::lower_bound(views_, position, {}, &View::position);
  if (view == views_.end() || view->position != position) return;
  unread_.push_back(view->record->id);
  views_.erase(view);
}

const RecordPtr& KeyframeLog::operator[](std::size_t i) const {
  static const RecordPtr kNone;
  const auto view = std::ranges::lower_bound(views_, i, {}, &View::position);
  return view != views_.end() && view->position == i ? view->record : kNone;
}

std::vector<KeyframePlace> KeyframeLog::chain() const {
  std::vector<KeyframePlace> out;
  out.reserve(places_.size());
  for (const KeyframePlace& place : places_)
    if (place.known()) out.push_back(place);
  std::ranges::stable_sort(out, {}, &KeyframePlace::index);
  const auto same = [](const KeyframePlace& a, const KeyframePlace& b) { return a.index == b.index; };
  out.erase(std::unique(out.begin(), out.end(), same), out.end());
  return out;
}

bool KeyframeLog::is_whole(std::size_t extent) const {
  return std::ranges::none_of(gaps_, [&](std::uint32_t gap) { return gap < extent; });
}

std::size_t KeyframeLog::most_whole() const {
  const auto first = std::ranges::min_element(gaps_);
  return first == gaps_.end() ? size() : *first;
}

std::vector<RecordId> KeyframeLog::let_go() { return std::exchange(unread_, {}); }

}  // namespace onemap::mapping
