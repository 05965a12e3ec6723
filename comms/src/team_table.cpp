#include "team_table.hpp"

#include <algorithm>

namespace onemap::comms {

namespace {
// Counters go round (RFC 1982); 0 is never said.
bool newer(std::uint32_t a, std::uint32_t b) { return b == 0 ? a != 0 : static_cast<std::int32_t>(a - b) > 0; }
}  // namespace

TeamTable::TeamTable(const RobotId& self, std::uint64_t incarnation, std::size_t max_robots, std::size_t max_neighbours,
                     Memory& memory)
    : self_(self),
      max_robots_(max_robots),
      for_neighbours_(std::min(max_neighbours, max_robots / 4)),
      robots_(&memory),
      traces_(&memory) {
  entry(self, incarnation);
}

RobotStatus& TeamTable::entry(const RobotId& robot, std::uint64_t incarnation) {
  RobotStatus& status = robots_[robot];
  if (incarnation > status.incarnation) {
    status = {};
    status.robot = robot;
    status.incarnation = incarnation;
  }
  return status;
}

TeamTable::Merge TeamTable::merge(const RobotStatus& status, Instant now) {
  const auto at = robots_.find(status.robot);
  if (at == robots_.end()) return Merge::unknown;
  const bool self = status.robot == self_;
  RobotStatus& known = at->second;
  if (status.incarnation > known.incarnation) return self ? Merge::later_self : Merge::unknown;
  if (status.incarnation < known.incarnation || status.counter == known.counter) return Merge::known;
  if (!newer(status.counter, known.counter)) return Merge::older;
  if (self) {
    known.counter = status.counter;
    unsaid_ = true;
    return Merge::about_self;
  }
  known = status;
  traces_[status.robot].last_sign = now;
  return Merge::newer;
}

void TeamTable::met(const RobotId& robot, std::uint64_t incarnation, Instant now) {
  if (!room_for(robot, true)) return;
  entry(robot, incarnation);
  traces_[robot].last_sign = now;
}

void TeamTable::left(const RobotId& robot) {
  if (logs_of(robot) > 0 || robot == self_) return;
  robots_.erase(robot);
  traces_.erase(robot);
}

void TeamTable::recorded(const LogId& log, bool first_of_log, Instant now) {
  Trace& trace = traces_[log.robot];
  if (first_of_log) ++trace.logs;
  trace.life = std::max(trace.life, log.incarnation);
  trace.last_sign = now;
  if (log.robot != self_) entry(log.robot, log.incarnation);
}

void TeamTable::start(Instant now) {
  for (auto& [robot, trace] : traces_) trace.last_sign = std::max(trace.last_sign, now);
}

bool TeamTable::room_for(const RobotId& robot, bool neighbour) const {
  return robots_.contains(robot) || robots_.size() < max_robots_ - (neighbour ? 0 : for_neighbours_);
}

std::size_t TeamTable::logs_of(const RobotId& robot) const {
  const auto at = traces_.find(robot);
  return at == traces_.end() ? 0 : at->second.logs;
}

std::uint64_t TeamTable::life_in_records(const RobotId& robot) const {
  const auto at = traces_.find(robot);
  return at == traces_.end() ? 0 : at->second.life;
}

Instant TeamTable::last_sign(const RobotId& robot) const {
  const auto at = traces_.find(robot);
  return at == traces_.end() ? Instant{} : at->second.last_sign;
}

bool TeamTable::set_own(std::uint64_t frontier_digest, std::uint64_t map_digest, std::uint8_t flags) {
  RobotStatus& status = mine();
  if (status.frontier_digest == frontier_digest && status.map_digest == map_digest && status.flags == flags)
    return false;
  status.frontier_digest = frontier_digest;
  status.map_digest = map_digest;
  status.flags = flags;
  unsaid_ = true;
  return true;
}

const RobotStatus& TeamTable::say_own() {
  RobotStatus& status = mine();
  if (unsaid_ && ++status.counter == 0) status.counter = 1;
  unsaid_ = false;
  return status;
}

}  // namespace onemap::comms
