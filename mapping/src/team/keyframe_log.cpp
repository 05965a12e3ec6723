#include "mapping/team/keyframe_log.hpp"

#include <algorithm>
#include <utility>

#include "mapping/records/keyframe.hpp"

namespace onemap::mapping {

Status KeyframeLog::add(const RecordPtr& record) {
  if (size_ == kMost) return Error{"keyframe record", "this robot has as many as are looked at"};
  const auto position = static_cast<std::uint32_t>(size_++);
  if (record->dropped) {
    gaps_.push_back({position, record->id.seq});
    return success();
  }
  const auto keyframe = decode_keyframe(record->body);
  if (!keyframe) {
    placeless_.push_back({position, record->id.seq});
    return keyframe.error();
  }
  const KeyframePlace place{keyframe->index, keyframe->anchor,           position,      record->id.seq,
                            false,           keyframe->T_robot_keyframe, keyframe->time};
  const bool saw_something = !keyframe->features.empty() || keyframe->grid.width > 0;
  if (!saw_something && replace(record->seal.replaces, place)) {
    placeless_.push_back({position, record->id.seq});
    return success();
  }
  if (saw_something) views_.push_back({position, record});
  places_.push_back(place);
  return success();
}

bool KeyframeLog::replace(std::uint32_t sequence, const KeyframePlace& by) {
  auto at = std::ranges::lower_bound(places_, sequence, {}, &KeyframePlace::sequence);
  if (at == places_.end() || at->sequence != sequence) {
    const auto gap = std::ranges::find(gaps_, sequence, &Gap::sequence);
    const auto other = std::ranges::lower_bound(placeless_, sequence, {}, &Gap::sequence);
    const bool is_gap = gap != gaps_.end();
    if (!is_gap && (other == placeless_.end() || other->sequence != sequence)) return false;
    at = places_.insert(at, by);
    at->position = is_gap ? gap->position : other->position;
    is_gap ? gaps_.erase(gap) : placeless_.erase(other);
  }
  const KeyframePlace was = std::exchange(*at, by);
  at->position = was.position;
  at->sequence = sequence;
  at->gone = true;
  if (!was.gone) gone_.push_back(at->position);
  const auto view = std::ranges::lower_bound(views_, at->position, {}, &View::position);
  if (view == views_.end() || view->position != at->position) return true;
  unread_.push_back(view->record->id);
  views_.erase(view);
  return true;
}

const RecordPtr& KeyframeLog::operator[](std::size_t i) const {
  static const RecordPtr kNone;
  const auto view = std::ranges::lower_bound(views_, i, {}, &View::position);
  return view != views_.end() && view->position == i ? view->record : kNone;
}

const KeyframePlace* KeyframeLog::place(std::size_t position) const {
  const auto at = std::ranges::lower_bound(places_, position, {}, &KeyframePlace::position);
  return at != places_.end() && at->position == position ? &*at : nullptr;
}

std::vector<KeyframePlace> KeyframeLog::chain() const {
  std::vector<KeyframePlace> out(places_.begin(), places_.end());
  std::ranges::stable_sort(out, {}, &KeyframePlace::index);
  const auto same = [](const KeyframePlace& a, const KeyframePlace& b) { return a.index == b.index; };
  out.erase(std::unique(out.begin(), out.end(), same), out.end());
  return out;
}

bool KeyframeLog::is_whole(std::size_t extent) const {
  return std::ranges::none_of(gaps_, [&](const Gap& gap) { return gap.position < extent; });
}

std::size_t KeyframeLog::most_whole() const { return gaps_.empty() ? size() : gaps_.front().position; }

std::vector<RecordId> KeyframeLog::let_go() { return std::exchange(unread_, {}); }

}  // namespace onemap::mapping
