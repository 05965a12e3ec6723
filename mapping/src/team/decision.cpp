#include "mapping/team/decision.hpp"

#include <algorithm>

#include "mapping/team/election.hpp"
#include "mapping/team/link_table.hpp"

namespace onemap::mapping {

bool same_solution(const SolutionRecord* a, const SolutionRecord* b) {
  if (a == nullptr || b == nullptr) return a == b;
  return a == b || encode(*a) == encode(*b);
}

std::optional<RobotId> Decision::decider(const Agreement& team) const {
  const auto may = [&](const RobotId& robot) { return !team.gone().contains(robot) && !passed_over_.contains(robot); };
  return elect(islands(team.robots(), counting_links(team.log())), may);
}

const SolutionRecord* Decision::made(const Agreement& team, TeamSolver& solver) const {
  const auto confirmed = [&](const RobotId& robot) -> const SolutionRecord* {
    const TeamMember* member = team.log().find(robot);
    if (member == nullptr || !member->solution) return nullptr;
    const auto wanted = solver.wanted(team, &*member->solution);
    return wanted && agree(team.log(), *member->solution, *wanted, TeamSolver::kSame_m) ? &*member->solution : nullptr;
  };
  const auto elected = decider(team);
  if (elected)
    if (const SolutionRecord* made = confirmed(*elected)) return made;
  for (const RobotId& robot : team.robots())
    if (team.gone().contains(robot) || passed_over_.contains(robot))
      if (const SolutionRecord* made = confirmed(robot)) return made;
  return nullptr;
}

std::optional<DeciderPassedOver> Decision::look(const Agreement& team, bool due, TeamSolver& solver, Instant now) {
  if (!due) {
    patience_.reset();
    passed_over_.clear();
    return std::nullopt;
  }
  const auto elected = decider(team);
  if (!elected || *elected == team.log().self() || !patience_.exhausted(*elected, made(team, solver) == nullptr, now))
    return std::nullopt;
  passed_over_.insert(*elected);
  const TeamMember* member = team.log().find(*elected);
  return DeciderPassedOver{*elected, member != nullptr && member->solution.has_value()};
}

}  // namespace onemap::mapping
