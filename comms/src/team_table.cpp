#include "team_table.hpp"

#include <tuple>

namespace onemap::comms {

TeamTable::TeamTable(const RobotId& self, std::uint64_t incarnation, std::size_t max_robots)
    : self_(self), max_robots_(max_robots) {
  RobotStatus& own = robots_[self];
  own.robot = self;
  own.incarnation = incarnation;
}

TeamTable::Merge TeamTable::merge(const RobotStatus& status) {
  if (status.robot == self_) return status.incarnation > own().incarnation ? Merge::about_self : Merge::known;
  const auto at = robots_.find(status.robot);
  if (at == robots_.end()) {
    if (robots_.size() >= max_robots_) return Merge::full;
    robots_.emplace(status.robot, status);
    return Merge::newer;
  }
  RobotStatus& known = at->second;
  if (std::tie(status.incarnation, status.counter) <= std::tie(known.incarnation, known.counter)) return Merge::known;
  known = status;
  return Merge::newer;
}

bool TeamTable::set_own(std::uint64_t frontier_digest, std::uint64_t map_digest, std::uint8_t flags) {
  RobotStatus& own = robots_.at(self_);
  if (own.frontier_digest == frontier_digest && own.map_digest == map_digest && own.flags == flags) return false;
  own.frontier_digest = frontier_digest;
  own.map_digest = map_digest;
  own.flags = flags;
  unsaid_ = true;
  return true;
}

const RobotStatus& TeamTable::say_own() {
  RobotStatus& own = robots_.at(self_);
  if (unsaid_) ++own.counter;
  unsaid_ = false;
  return own;
}

}  // namespace onemap::comms
