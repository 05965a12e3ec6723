#include "mapping/team/decision.hpp"

#include <algorithm>

#include "mapping/team/election.hpp"
#include "mapping/team/link_table.hpp"

namespace onemap::mapping {

namespace {
constexpr Duration kLookAgain = std::chrono::seconds(2);  // at what was refuted, while robots map
}

std::optional<RobotId> Decision::decider(const Agreement& team) const {
  const auto may = [&](const ChainId& chain) { return team.present(chain) && !passed_over_.contains(chain.robot); };
  return elect(islands(team.chains(), counting_links(team.log())), may);
}

bool Decision::confirmed(const Agreement& team, const RobotId& robot, TeamSolver& solver) {
  const TeamMember* member = team.log().find(robot);
  if (member == nullptr || !member->solution) return false;
  const SolutionRecord& solution = *member->solution;
  const auto says_the_same = [&] {
    const auto wanted = solver.wanted(team, &solution);
    return wanted && agree(team.log(), solution, *wanted, TeamSolver::kSame_m);
  };
  if (team.ready()) return says_the_same();
  if (robot == team.log().self()) return true;
  Looked& looked = looked_[robot];
  const bool same = looked.digest == member->solution_digest;
  if (!same || (!looked.confirmed && team.now() - looked.at >= kLookAgain))
    looked = {member->solution_digest, says_the_same(), team.now()};
  return looked.confirmed;
}

const TeamMember* Decision::made(const Agreement& team, TeamSolver& solver) {
  const auto elected = decider(team);
  if (elected && confirmed(team, *elected, solver)) return team.log().find(*elected);
  for (const RobotId& robot : team.robots())
    if ((team.gone().contains(robot) || passed_over_.contains(robot)) && confirmed(team, robot, solver))
      return team.log().find(robot);
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
