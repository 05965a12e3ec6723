#include "mapping/team/decision.hpp"

#include <algorithm>

#include "mapping/team/election.hpp"
#include "mapping/team/link_table.hpp"

namespace onemap::mapping {

bool same_solution(const std::optional<SolutionRecord>& a, const std::optional<SolutionRecord>& b) {
  return a.has_value() == b.has_value() && (!a || encode(*a) == encode(*b));
}

std::optional<RobotId> Decision::decider(const Agreement& team) const {
  const auto may = [&](const RobotId& robot) { return !team.gone().contains(robot) && !passed_over_.contains(robot); };
  return elect(islands(team.robots(), counting_links(team.log())), may);
}

bool Decision::made(const Agreement& team, const SolutionRecord& wanted) const {
  const auto elected = decider(team);
  return std::ranges::any_of(team.robots(), [&](const RobotId& robot) {
    const bool may = robot == elected || team.gone().contains(robot) || passed_over_.contains(robot);
    const TeamMember* member = team.log().find(robot);
    return may && member != nullptr && same_solution(member->solution, wanted);
  });
}

std::optional<DeciderPassedOver> Decision::look(const Agreement& team, const std::optional<SolutionRecord>& final,
                                                Instant now) {
  if (!final) {
    patience_.reset();
    passed_over_.clear();
    return std::nullopt;
  }
  const auto elected = decider(team);
  if (!elected || *elected == team.log().self() || !patience_.exhausted(*elected, !made(team, *final), now))
    return std::nullopt;
  passed_over_.insert(*elected);
  const TeamMember* member = team.log().find(*elected);
  return DeciderPassedOver{*elected, member != nullptr && member->solution.has_value()};
}

}  // namespace onemap::mapping
