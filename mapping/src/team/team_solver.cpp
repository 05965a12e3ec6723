#include "mapping/team/team_solver.hpp"

#include <algorithm>

namespace onemap::mapping {

namespace {
constexpr std::size_t kAnswers = 4;  // whoever may decide has one, and there is one from nothing
// Two megabytes: who says that it can hold less, by mistake or to do harm, does not make everybody's map as small.
constexpr std::uint32_t kFewestBlocks = 512;
}  // namespace

// A map that is too large for one robot is another map there: the least budget counts, of those that are gone as well,
// so that the map does not change when they come and go.
MapParameters TeamSolver::held_by_all(const TeamLog& log) const {
  MapParameters out = map_;
  for (const RobotId& robot : log.robots())
    if (const TeamMember* member = log.find(robot); member != nullptr && member->map_blocks > 0)
      out.blocks = std::min(out.blocks, std::max(kFewestBlocks, member->map_blocks));
  return out;
}

std::optional<SolutionRecord> TeamSolver::wanted(const Agreement& team, const SolutionRecord* in_use) {
  if (team.chains().empty()) return std::nullopt;
  if (team.ready()) in_use = nullptr;
  const std::uint64_t revision = team.log().revision();
  std::erase_if(answers_, [&](const Answer& answer) { return answer.revision != revision; });
  std::optional<std::vector<std::uint8_t>> from;
  if (in_use != nullptr) from = encode(*in_use);
  const auto known = std::ranges::find(answers_, from, &Answer::in_use);
  if (known != answers_.end()) return known->solution;
  if (answers_.size() == kAnswers) answers_.erase(answers_.begin());
  ++solved_;
  answers_.push_back({revision, std::move(from), solve_team(team.log(), team.chains(), in_use)});
  answers_.back().solution.map = held_by_all(team.log());
  return answers_.back().solution;
}

}  // namespace onemap::mapping
