#pragma once
#include <cstdint>
#include <map>

#include "comms/status.hpp"

namespace onemap::comms {

// The newest word of every robot about itself, its own included.
class TeamTable {
 public:
  TeamTable(const RobotId& self, std::uint64_t incarnation, std::size_t max_robots);

  enum class Merge { newer, known, full, about_self };
  Merge merge(const RobotStatus& status);
  bool set_own(std::uint64_t frontier_digest, std::uint64_t map_digest, std::uint8_t flags);  // true: changed
  const RobotStatus& say_own();  // own entry as it goes out: what is said twice under one counter is equal

  const std::map<RobotId, RobotStatus>& robots() const { return robots_; }
  const RobotStatus& own() const { return robots_.at(self_); }

 private:
  RobotId self_;
  std::size_t max_robots_;
  bool unsaid_ = true;
  std::map<RobotId, RobotStatus> robots_;
};

}  // namespace onemap::comms
