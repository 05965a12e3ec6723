#pragma once
#include <cstdint>
#include <map>
#include <vector>

#include "mapping/team/rulings.hpp"
#include "mapping/team/team_member.hpp"

namespace onemap::mapping {

// Everybody's records as members: one for each life of each robot, a chain. An earlier life keeps its worth: its map
// and its links count like anybody's; but only the newest life of a robot, its present one, can be asked for anything.
// Of this robot's own lives the present one is that which it has begun itself. Which records count, and in what order,
// follows from the record set and not from the order in which the logs arrive. Used by one thread.
class TeamLog {
 public:
  static constexpr std::size_t kMaxRobots = 256;  // of whose records something is kept; more are refused
  static constexpr std::size_t kMaxLives = 32;    // of a robot, the newest; what is earlier is not looked at

  // bodies_elsewhere: those of voxels can be read again, so they are not held.
  TeamLog(const RobotId& self, std::uint64_t incarnation, bool bodies_elsewhere = false)
      : self_{self, incarnation}, bodies_elsewhere_(bodies_elsewhere) {}

  // This robot goes on under another number. repeats: it writes its records again, and those of its life before no
  // longer count; else that life keeps its worth.
  void begin_life(std::uint64_t incarnation, bool repeats);

  // Takes a record of any robot; each log comes in order. False: it is of a life that is not looked at, and changes
  // nothing. The error says why the record is refused.
  Result<bool> apply(const RecordPtr& record, Instant now);

  // Maps of fewer than so many of this chain's voxel records are not made any more: see SubmapLog.
  std::vector<RecordId> let_go(const ChainId& chain, std::size_t submaps);
  // This chain's keyframes of which the places remain: once each.
  std::vector<RecordId> let_go_keyframes(const ChainId& chain);

  const RobotId& self() const { return self_.robot; }
  const ChainId& own_chain() const { return self_; }
  const TeamMember* own() const { return find(self_); }  // nullptr: no record of it yet
  const std::map<ChainId, TeamMember>& members() const { return members_; }
  const TeamMember* find(const ChainId& chain) const;  // nullptr: no record of it
  ChainId present(const RobotId& robot) const;         // its newest life; of incarnation 0 when nothing is known of it
  const TeamMember* find(const RobotId& robot) const { return find(present(robot)); }  // its present life
  std::vector<RobotId> robots() const;  // whose present lives count: with a valid Hello; sorted
  std::vector<ChainId> chains() const;  // all lives that count, but those that a later one repeats; sorted
  const Rulings& rulings() const { return rulings_; }  // of pairs of chains, by people
  // Another number whenever a record came, or a life began, that the pose graph may look different for.
  std::uint64_t revision() const { return revision_; }

 private:
  Result<TeamMember*> member_of(const LogId& log);  // nullptr: of a life that is not looked at
  TeamMember* begin(const ChainId& chain);

  ChainId self_;
  bool bodies_elsewhere_;
  std::uint64_t repeated_ = 0;  // the life of this robot that its present one repeats; 0: none
  std::map<ChainId, TeamMember> members_;
  Rulings rulings_;
  std::uint64_t revision_ = 0;
};

}  // namespace onemap::mapping
