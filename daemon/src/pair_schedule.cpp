#include "daemon/pair_schedule.hpp"

namespace onemap::daemon {

const PairSchedule::Look* PairSchedule::last_look(const RobotId& other, const TeamMember& theirs) const {
  const auto at = looks_.find(other);
  return at != looks_.end() && at->second.incarnation == theirs.incarnation ? &at->second : nullptr;
}

bool PairSchedule::linked(const RobotId& other, const TeamMember& theirs) const {
  const Look* look = last_look(other, theirs);
  return look != nullptr && look->linked;
}

bool PairSchedule::due(const TeamMember& mine, const RobotId& other, const TeamMember& theirs, Instant now) const {
  const Look* look = last_look(other, theirs);
  const std::size_t have = mine.keyframes.size() + theirs.keyframes.size();
  if (mine.keyframes_complete() && theirs.keyframes_complete()) return look == nullptr || !look->final;
  if (interval_ <= Duration::zero() || std::min(mine.keyframes.size(), theirs.keyframes.size()) < kFewest) return false;
  if (look == nullptr) return true;
  const std::size_t seen = look->mine + look->theirs;
  return now >= look->next && (look->linked ? 2 * have >= 3 * seen : have > seen);
}

void PairSchedule::verified(const TeamMember& mine, const RobotId& other, const TeamMember& theirs, bool linked,
                            Instant began, Instant now) {
  const bool final = mine.keyframes_complete() && theirs.keyframes_complete();
  const Instant next = now + std::max<Duration>(interval_, 10 * (now - began));
  looks_[other] = {theirs.incarnation, mine.keyframes.size(), theirs.keyframes.size(), linked, final, next};
}

}  // namespace onemap::daemon
