#include "mapping/team/pair_schedule.hpp"

#include <algorithm>

namespace onemap::mapping {

const PairSchedule::Look* PairSchedule::last_look(const ChainId& other) const {
  const auto at = looks_.find(other);
  return at != looks_.end() ? &at->second : nullptr;
}

bool PairSchedule::linked(const ChainId& other) const {
  const Look* look = last_look(other);
  return look != nullptr && look->linked;
}

bool PairSchedule::due(const Keyframes& mine, const ChainId& other, const Keyframes& theirs, Instant now) const {
  const Look* look = last_look(other);
  if (mine.all && theirs.all) {
    if (mine.here == 0 || theirs.here == 0) return false;  // there is nothing to look at
    return look == nullptr || !look->final || look->mine != mine.here || look->theirs != theirs.here;
  }
  if (interval_ <= Duration::zero() || std::min(mine.here, theirs.here) < kFewest || now < next_) return false;
  if (look == nullptr) return true;
  const std::size_t have = mine.here + theirs.here, seen = look->mine + look->theirs;
  return now >= look->next && (look->linked && !look->doubted ? 2 * have >= 3 * seen : have > seen);
}

PairSchedule::Gain PairSchedule::gain(const Keyframes& mine, const ChainId& other, const Keyframes& theirs) const {
  const Look* look = last_look(other);
  const std::size_t have = mine.here + theirs.here, seen = look == nullptr ? 0 : look->mine + look->theirs;
  return {look == nullptr || !look->linked, have - std::min(have, seen)};
}

void PairSchedule::verified(const Keyframes& mine, const ChainId& other, const Keyframes& theirs, bool linked,
                            Instant now) {
  const Look* before = last_look(other);
  const bool final = mine.all && theirs.all;
  const bool doubted = !linked && !final && before != nullptr && before->linked && !before->doubted;
  looks_[other] = {mine.here, theirs.here, linked || doubted, doubted, final, now, now + interval_};
}

void PairSchedule::took(const ChainId& other, Duration cost) {
  const auto look = looks_.find(other);
  if (look == looks_.end()) return;
  look->second.next = look->second.at + cost + std::max<Duration>(interval_, 10 * cost);
  next_ = look->second.at + 3 * cost;
}

}  // namespace onemap::mapping
