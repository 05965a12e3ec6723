#pragma once
#include <optional>
#include <set>

#include "mapping/team/agreement.hpp"
#include "mapping/team/patience.hpp"
#include "mapping/team/team_event.hpp"

namespace onemap::mapping {

// Who has to publish the team's solution, and whether that has been done. Used by one thread.
class Decision {
 public:
  explicit Decision(Duration patience) : patience_(patience) {}

  // The elected one of those that are there and have not been passed over.
  std::optional<RobotId> decider(const Agreement& team) const;
  // Whether the wanted solution was published by somebody who may: the elected robot, or one that would be elected if
  // it had not gone or been passed over. What else anybody publishes does not count: the links that are here say what
  // is wanted, so nobody can put a robot where the records do not.
  bool made(const Agreement& team, const SolutionRecord& wanted) const;
  // To be asked regularly: once the final solution can be computed, whoever should publish it has a while; then it is
  // passed over, which is told once, and the next one's turn comes.
  std::optional<DeciderPassedOver> look(const Agreement& team, const std::optional<SolutionRecord>& final, Instant now);

 private:
  Patience<RobotId> patience_;
  std::set<RobotId> passed_over_;
};

bool same_solution(const std::optional<SolutionRecord>& a, const std::optional<SolutionRecord>& b);

}  // namespace onemap::mapping
