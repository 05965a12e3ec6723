#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "mapping/mesh.hpp"
#include "mapping/team/records.hpp"

namespace onemap::mapping {

// The global map as a pure function of a record set: submaps of the robots in a Solution, each moved by T_global_robot
// and resampled into one voxel map with integer accumulators. Any order of the same records gives the same bytes.
struct AtlasConfig {
  VoxelMapConfig map;  // the global map's voxel size and budget
};

// The submap record of some blocks of a local map.
SubmapRecord make_submap(const VoxelMap& map, std::span<const BlockKey> blocks);

class Atlas {
 public:
  explicit Atlas(const AtlasConfig& config);
  struct Submap {
    RobotId robot;
    std::uint32_t sequence = 0;  // of the record in its log
    const SubmapRecord* record = nullptr;
  };
  // Builds the global map anew. Robots that the solution does not contain are left out. A block that a robot published
  // again (a later sequence) replaces its earlier version. The order of the submaps does not matter.
  void rebuild(const SolutionRecord& solution, std::span<const Submap> submaps);
  const VoxelMap& map() const;
  std::uint64_t digest() const;  // of the map and the solution

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace onemap::mapping
