#pragma once
#include <vector>

#include "start_poses.hpp"

namespace onemap::mapping {

// One group of chains, solved.
struct SolvedGroup {
  ChainGroup group;
  std::size_t reference = 0;             // of the index
  std::vector<std::size_t> anchors{};    // of the index, ascending
  std::vector<Pose> poses{};             // of these
  std::vector<std::size_t> links{};      // of the index, ascending: those with both ends in the group that may count
  std::vector<bool> used{};              // of these
  std::vector<double> squared_errors{};  // of these, in sigmas
};

SolvedGroup solve_group(const GraphIndex& index, const ChainFrames& frames, const ChainGroup& group,
                        const Joining& joining, const InUse& in_use, const PoseGraphConfig& config,
                        SolveEffort& effort);

}  // namespace onemap::mapping
