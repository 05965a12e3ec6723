#include "session/conduct.hpp"

#include <algorithm>

namespace onemap::comms {

std::optional<Duration> Conduct::strike(Instant now, const PublicKey& who) {
  if (!records_.contains(who) && records_.size() >= kMost)
    records_.erase(std::ranges::min_element(records_, {}, [](const auto& entry) { return entry.second.until; }));
  Record& record = records_[who];
  while (record.count > 0 && now - record.strikes[record.count - 1] >= kWithin) --record.count;
  std::shift_right(record.strikes.begin(), record.strikes.end(), 1);
  record.strikes.front() = now;
  if (++record.count < kStrikes) return std::nullopt;
  record.count = 0;
  const Duration penalty = record.next_penalty;
  record.until = now + penalty;
  record.next_penalty = std::min(2 * penalty, kLongestPenalty);
  return penalty;
}

bool Conduct::shut_out(Instant now, const PublicKey& who) const {
  const auto at = records_.find(who);
  return at != records_.end() && now < at->second.until;
}

}  // namespace onemap::comms
