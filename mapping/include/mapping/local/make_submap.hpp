#pragma once
#include <span>

#include "mapping/local/voxel_map.hpp"
#include "mapping/records/submap.hpp"

namespace onemap::mapping {

// The submap record of some blocks of a local map (those that the map has, sorted, each once), in the robot's own
// frame.
SubmapRecord make_submap(const VoxelMap& map, std::span<const BlockKey> blocks);

}  // namespace onemap::mapping
