#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "mapping/team/pose_graph_solution.hpp"
#include "mapping/team/rulings.hpp"
#include "mapping/team/team_log.hpp"

// Why two robots are in one map, or are not: for the person who asks.
namespace onemap::mapping {

// What is known of a pair of lives, or of one life's own loops (a = b).
struct WhyPair {
  ChainId a, b;                            // a <= b
  std::optional<LinkRecord> link;          // the verification that counts; nothing: nobody has looked or said so
  std::optional<Rulings::Ruling> ruling;   // what a person said last
  PairVerdict verdict;                     // of the pose graph over the pair
  std::map<LinkUse, std::uint32_t> pairs;  // verified pairs of keyframes, by what the graph does with them
  double worst = 0;                        // of those in use the largest squared error in sigmas
};

struct Why {
  bool one_map = false;        // both robots' present lives are in the solution
  std::vector<ChainId> way;    // in one map: from a's present life to b's over pairs of lives that links in use join
  std::vector<WhyPair> pairs;  // of all lives of the two, sorted; what nobody looked at or spoke of is left out
};

// By the records that are here, and the solution in use; nullptr: there is none. Solves the pose graph once.
Why why(const TeamLog& log, const SolutionRecord* in_use, const RobotId& a, const RobotId& b);

}  // namespace onemap::mapping
