#pragma once
#include <map>
#include <optional>
#include <set>

#include "mapping/team/agreement.hpp"
#include "mapping/team/patience.hpp"
#include "mapping/team/team_event.hpp"
#include "mapping/team/team_solver.hpp"

namespace onemap::mapping {

// Who has to publish the team's solution, and whose counts. Used by one thread.
class Decision {
 public:
  explicit Decision(Duration patience) : patience_(patience) {}

  // The elected one of those that are there and have not been passed over.
  std::optional<RobotId> decider(const Agreement& team) const;
  // Whose solution counts: that of the elected robot, or of one that would be elected if it had not gone or been
  // passed over; and only when the records that are here, solved from there, say the same. So nobody can put a robot
  // where the records do not. While robots map, a solution is looked at once, and again after a while when it was
  // refuted. nullptr: nobody's; else it lives as long as the log is not changed.
  const TeamMember* made(const Agreement& team, TeamSolver& solver);
  // To be asked regularly: once a solution can be computed (it is due), whoever should publish it has a while;
  // then it is passed over, which is told once, and the next one's turn comes.
  std::optional<DeciderPassedOver> look(const Agreement& team, bool due, TeamSolver& solver, Instant now);

 private:
  struct Looked {  // at a robot's solution while robots map
    std::uint64_t digest = 0;
    bool confirmed = false;
    Instant at{};
  };
  bool confirmed(const Agreement& team, const RobotId& robot, TeamSolver& solver);

  Patience<RobotId> patience_;
  std::set<RobotId> passed_over_;
  std::map<RobotId, Looked> looked_;
};

}  // namespace onemap::mapping
