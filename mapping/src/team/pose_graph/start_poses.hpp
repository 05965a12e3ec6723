#pragma once
#include <vector>

#include "components.hpp"
#include "in_use.hpp"

namespace onemap::mapping {

// The anchor of a group that keeps its pose: that of the solution in use as long as it is in the group, else the first
// one of the chain with the most and best matches.
std::size_t reference_of(const GraphIndex& index, const ChainGroup& group, const Joining& joining, const InUse& in_use);

// Where the group's anchors are before anything is solved, in their order: as in use, new ones hanging on those before
// them as their chain by itself has them; chains that come from elsewhere are laid down by the best link to those that
// are there.
std::vector<Pose> start_poses(const GraphIndex& index, const ChainFrames& frames, const ChainGroup& group,
                              const Joining& joining, const InUse& in_use, std::size_t reference);

}  // namespace onemap::mapping
