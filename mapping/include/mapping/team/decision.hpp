#pragma once
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
  // The solution that counts: that of the elected robot, or of one that would be elected if it had not gone or been
  // passed over; and only when the records that are here, solved from there, say the same. So nobody can put a robot
  // where the records do not. nullptr: none; else it lives as long as the log is not changed.
  const SolutionRecord* made(const Agreement& team, TeamSolver& solver) const;
  // To be asked regularly: once the final solution can be computed (it is due), whoever should publish it has a while;
  // then it is passed over, which is told once, and the next one's turn comes.
  std::optional<DeciderPassedOver> look(const Agreement& team, bool due, TeamSolver& solver, Instant now);

 private:
  Patience<RobotId> patience_;
  std::set<RobotId> passed_over_;
};

bool same_solution(const SolutionRecord* a, const SolutionRecord* b);  // the same bytes, or neither is there

}  // namespace onemap::mapping
