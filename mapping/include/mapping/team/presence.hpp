#pragma once
#include <map>
#include <set>

#include "mapping/team/team_member.hpp"

namespace onemap::mapping {

// Who is there, by the last sign of life of each robot and the last record that came of it. Used by one thread.
class Presence {
 public:
  Presence(const RobotId& self, Duration lost_after) : self_(self), lost_after_(lost_after) {}

  // What the radio knows: when each robot was last known to live (there may be robots without records among them), and
  // of whom every record that anybody is known to hold is here. This robot's own sign of life says until when it
  // listened: whoever was stopped for an hour did not hear anybody fall silent in it.
  void update(std::map<RobotId, Instant> last_sign, std::set<RobotId> records_complete);

  Duration silent(const RobotId& robot, const TeamMember& member, Instant now) const;
  // Silent for longer than is waited for, with no record of it coming either; this robot itself never is.
  bool gone(const RobotId& robot, const TeamMember& member, Instant now) const;
  bool all_known_here(const RobotId& robot) const { return records_complete_.contains(robot); }
  bool quiet(const TeamMember& member, Instant now) const;  // no record of it came for as long as one waits for a robot

 private:
  const RobotId self_;
  const Duration lost_after_;
  std::map<RobotId, Instant> last_sign_;
  std::set<RobotId> records_complete_;
};

}  // namespace onemap::mapping
