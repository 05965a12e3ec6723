#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "mapping/team/agreement.hpp"
#include "mapping/team/team_graph.hpp"

namespace onemap::mapping {

// What the team's solution is to be, by the records that are here; solved anew only when they have changed. Used by one
// thread.
class TeamSolver {
 public:
  // Moves that are not worth a new solution, and how far two robots' arithmetic may lead apart.
  static constexpr double kWorth_m = 0.005, kSame_m = 0.015;

  explicit TeamSolver(const MapParameters& map) : map_(map) {}

  // Once all of the team has ended and is verified, a function of the records but the solutions; before, near to the
  // one in use. Nothing when no robot counts.
  std::optional<SolutionRecord> wanted(const Agreement& team, const SolutionRecord* in_use);
  std::uint64_t solved() const { return solved_; }  // how often

 private:
  MapParameters held_by_all(const TeamLog& log) const;

  struct Answer {
    std::uint64_t revision = 0;
    std::optional<std::vector<std::uint8_t>> in_use;
    SolutionRecord solution;
  };
  const MapParameters map_;
  std::vector<Answer> answers_;  // the last few
  std::uint64_t solved_ = 0;
};

}  // namespace onemap::mapping
