#pragma once
#include <optional>

#include "mapping/local/voxel_map.hpp"
#include "mapping/team/team_map.hpp"

namespace onemap::daemon {

// A team's map as it was at a moment, for whoever draws it while the team goes on: the records, which are shared and
// never change, and the global map's voxels, which do and are copied.
struct MapCopy {
  mapping::TeamLog log;
  std::optional<mapping::SolutionRecord> solution;  // of `map`; neither while there is no global map
  std::optional<mapping::VoxelMap> map;
  Duration took{};           // of the team's thread
  std::uint64_t digest = 0;  // as the team says it
};

// The same blocks in a map just large enough.
mapping::VoxelMap copy_of(const mapping::VoxelMap& map);

// On the team's thread: a memcpy of the atlas, and a pointer a record.
MapCopy copy_map(const mapping::TeamMap& team);

}  // namespace onemap::daemon
