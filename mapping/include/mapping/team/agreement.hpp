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
  const std::vector<RobotId>& robots() const { return robots_; }  // that count
  const std::set<RobotId>& gone() const { return gone_; }         // of those
  bool over() const;                                              // nobody writes more of its camera
  bool keyframes_here(const RobotId& robot) const;                // as many as will come
  bool all_here(const RobotId& robot) const;                      // as much as will come
  // Who has to look whether the two belong together: the lower id, the other one when that is gone. Nobody when both
  // are: then the records that there are decide.
  std::optional<RobotId> verifier(const RobotId& a, const RobotId& b) const;
  bool verified(const RobotId& a, const RobotId& b) const;  // with all keyframes, or there is nothing to look at
  bool looked_at_own(const RobotId& robot) const;           // for places that it came back to, or nobody will
  // Whether the links are all that will come: the work is over and every pair is verified.
  bool ready() const;
  Duration silent(const RobotId& robot) const;
  // Of others, for the final map: sorted by robot, each with the first thing that it owes. Not what follows from the
  // solution: who should have published it is not known here.
  std::vector<Waiting> waiting() const;

 private:
  const TeamMember& member(const RobotId& robot) const;
  bool nothing_more_comes(const RobotId& robot) const;
  std::optional<Waiting::What> owes(const RobotId& robot) const;

  const TeamLog& log_;
  const Presence& presence_;
  const Instant now_;
  std::vector<RobotId> robots_;
  std::set<RobotId> gone_;
};

}  // namespace onemap::mapping
