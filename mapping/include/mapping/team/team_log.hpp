#pragma once
#include <cstdint>
#include <map>
#include <vector>

#include "mapping/team/team_member.hpp"

namespace onemap::mapping {

// Everybody's records as members and their lives. A record of a newer life of another robot replaces what its earlier
// lives wrote; of this robot's own lives only the one counts that it has begun itself. Which records count, and in what
// order, follows from the record set and not from the order in which the logs arrive. Used by one thread.
class TeamLog {
 public:
  static constexpr std::size_t kMaxRobots = 256;  // of whose records something is kept; more are refused

  TeamLog(const RobotId& self, std::uint64_t incarnation) : self_(self), incarnation_(incarnation) {}

  // This robot goes on under another number and writes its records again; those of its life before no longer count.
  void begin_life(std::uint64_t incarnation);

  // Takes a record of any robot; each log comes in order. False: it is of an earlier life and changes nothing. The
  // error says why the record is refused.
  Result<bool> apply(const RecordPtr& record, Instant now);

  const RobotId& self() const { return self_; }
  const std::map<RobotId, TeamMember>& members() const { return members_; }
  const TeamMember* find(const RobotId& robot) const;  // nullptr: no record of it
  std::vector<RobotId> robots() const;                 // that count: with a valid Hello; sorted
  // Another number whenever a record came, or a life began, that the pose graph may look different for.
  std::uint64_t revision() const { return revision_; }

 private:
  Result<TeamMember*> member_of(const LogId& log);  // nullptr: of an earlier life

  const RobotId self_;
  std::uint64_t incarnation_;
  std::map<RobotId, TeamMember> members_;
  std::uint64_t revision_ = 0;
};

}  // namespace onemap::mapping
