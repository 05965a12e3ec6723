#pragma once
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "mapping/team/presence.hpp"
#include "mapping/team/team_log.hpp"

namespace onemap::mapping {

// What is waited for, of whom, and for how long that robot has been silent.
struct Waiting {
  enum class What { records, end, link, solution };
  RobotId robot;
  What what = What::records;
  Duration silent{};
};

// What the team has and what it lacks for its final map, at one moment. A robot that is gone is not waited for: the map
// is made without what is missing of it. Who is gone decides only whether one waits; what the map is follows from the
// records, so robots with equal records that do not wait end with equal maps. Looks at the log; made anew for each
// moment.
class Agreement {
 public:
  Agreement(const TeamLog& log, const Presence& presence, Instant now);

  const TeamLog& log() const { return log_; }
  Instant now() const { return now_; }
  const std::vector<RobotId>& robots() const { return robots_; }  // whose present lives count
  const std::vector<ChainId>& chains() const { return chains_; }  // all lives that count
  const std::set<RobotId>& gone() const { return gone_; }         // of the robots
  bool present(const ChainId& chain) const;                       // somebody goes on with this life, and is not gone
  bool over() const;                                              // nobody writes more of its camera
  bool keyframes_here(const ChainId& chain) const;                // as many as will come
  bool all_here(const ChainId& chain) const;                      // as much as will come
  // Who has to look whether the two belong together: the lower one, the other one when that is gone or an earlier life.
  // Nobody when both are: then the records that there are decide.
  std::optional<RobotId> verifier(const ChainId& a, const ChainId& b) const;
  bool verified(const ChainId& a, const ChainId& b) const;  // with all keyframes, or there is nothing to look at
  bool looked_at_own(const RobotId& robot) const;           // for places that it came back to, or nobody will
  // Whether the links are all that will come: the work is over and every pair is verified.
  bool ready() const;
  Duration silent(const RobotId& robot) const;
  // Of others, for the final map: sorted by robot, each with the first thing that it owes. Not what follows from the
  // solution: who should have published it is not known here.
  std::vector<Waiting> waiting() const;

 private:
  const TeamMember& member(const ChainId& chain) const;
  const TeamMember& member(const RobotId& robot) const { return member(log_.present(robot)); }
  bool nothing_more_comes(const ChainId& chain) const;
  std::optional<Waiting::What> owes(const RobotId& robot) const;

  const TeamLog& log_;
  const Presence& presence_;
  const Instant now_;
  std::vector<RobotId> robots_;
  std::vector<ChainId> chains_;
  std::set<RobotId> gone_;
};

}  // namespace onemap::mapping
