#pragma once
#include <span>
#include <string>

#include "mapping/records/solution.hpp"
#include "mapping/team/pose_graph.hpp"
#include "mapping/team/team_log.hpp"

// The team's pose graph from its records, and what it says as a record.
namespace onemap::mapping {

// A chain for each of `lives` with a keyframe: its first anchor and those that something hangs on (a keyframe that was
// not replaced by its place alone, voxels, a link), by its odometry. A link for each pair of keyframes of the
// links that count, and of the chains' own loops. What the graph has no room for is counted in its refused().
PoseGraph team_graph(const TeamLog& log, std::span<const ChainId> lives);

// Solves it. With the solution in use: starts from there, and keeps its reference and the anchors that would hardly
// move. Without: a function of the records alone. With no keyframe anywhere the first life alone is the map.
SolutionRecord solve_team(const TeamLog& log, std::span<const ChainId> lives, const SolutionRecord* in_use = nullptr);

// The same as the graph says it, with a verdict for every link and pair; of all lives that count.
GraphSolution solve_graph(const TeamLog& log, const SolutionRecord* in_use);

// The graph as g2o text (pose_graph_g2o.hpp), solved from the solution in use.
std::string graph_text(const TeamLog& log, const SolutionRecord& in_use);

// Whether the two put the same robots in the same frame, and every anchor that b has and is here in the same place:
// none with a corner of its surroundings more than `bound_m` apart.
bool agree(const TeamLog& log, const SolutionRecord& a, const SolutionRecord& b, double bound_m);

}  // namespace onemap::mapping
