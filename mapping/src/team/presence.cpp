#include "mapping/team/presence.hpp"

#include <algorithm>

namespace onemap::mapping {

void Presence::update(std::map<RobotId, Instant> last_sign, std::set<RobotId> records_complete) {
  last_sign_ = std::move(last_sign);
  records_complete_ = std::move(records_complete);
}

Duration Presence::silent(const RobotId& robot, const TeamMember& member, Instant now) const {
  if (robot == self_) return Duration::zero();
  const auto sign = last_sign_.find(robot);
  const Instant last = sign == last_sign_.end() ? member.heard : std::max(member.heard, sign->second);
  const auto own = last_sign_.find(self_);
  const Instant listened = own == last_sign_.end() ? now : std::min(now, own->second);
  return std::max(Duration::zero(), Duration(listened - last));
}

bool Presence::gone(const RobotId& robot, const TeamMember& member, Instant now) const {
  return silent(robot, member, now) > lost_after_;
}

bool Presence::quiet(const TeamMember& member, Instant now) const { return now - member.heard > lost_after_; }

}  // namespace onemap::mapping
