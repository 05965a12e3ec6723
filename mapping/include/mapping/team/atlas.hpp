#pragma once
#include <cstdint>
#include <deque>
#include <memory>
#include <set>
#include <span>
#include <tuple>
#include <vector>

#include "mapping/local/make_submap.hpp"
#include "mapping/mesh.hpp"
#include "mapping/records/solution.hpp"
#include "mapping/records/submap.hpp"

namespace onemap::mapping {

// The global map as a pure function of a record set: submaps of the robots in a Solution, each moved by T_global_robot
// and resampled into one voxel map with integer accumulators. Any order of the same records gives the same bytes.
struct AtlasConfig {
  VoxelMapConfig map;  // the global map's voxel size and budget
};

struct AtlasCounters {                // since begin()
  std::uint64_t robots = 0;           // in the solution and with submaps
  std::uint64_t blocks = 0;           // of the robots, each counted once in its latest version
  std::uint64_t blocks_left_out = 0;  // their voxels are more than 4 times larger or smaller than the global map's
};

class Atlas {
 public:
  explicit Atlas(const AtlasConfig& config);
  struct Submap {
    RobotId robot;
    std::uint32_t sequence = 0;  // of the record in its log
    const SubmapRecord* record = nullptr;
  };
  // Builds the global map anew, one robot after the other, so that only one robot's submaps need to be decoded at a
  // time: begin() empties the map, then add() each robot of the solution in its order, once, with all its submaps. One
  // that the solution does not contain is left out. A block that a robot published again (a later sequence) replaces
  // its earlier version. The order of the submaps does not matter. The records must have passed decode_submap() (or
  // come from make_submap()) and live until the call returns.
  void begin(const SolutionRecord& solution);
  void add(const RobotId& robot, std::span<const Submap> submaps);
  const VoxelMap& map() const;
  const AtlasCounters& counters() const;
  std::uint64_t digest() const;  // of the map and the solution

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

// One robot's submaps with only those blocks that count: what was published again later is dropped as it comes, so
// memory grows with the map and not with how often it was published, and never beyond max_blocks.
class LatestSubmaps {
 public:
  LatestSubmaps(const RobotId& robot, std::size_t max_blocks) : robot_(robot), max_blocks_(max_blocks) {}
  // To be asked before a record is decoded, with the blocks that its header says it has.
  bool has_room(std::size_t blocks) const { return seen_.size() + blocks <= max_blocks_; }
  void add_older(std::uint32_t sequence, SubmapRecord record);  // in falling order of sequence
  std::span<const Atlas::Submap> submaps() const { return submaps_; }

 private:
  const RobotId robot_;
  const std::size_t max_blocks_;
  std::set<std::tuple<std::int32_t, std::int32_t, BlockKey>> seen_;  // voxel size, truncation, block
  std::deque<SubmapRecord> records_;                                 // a deque: submaps_ points into it
  std::vector<Atlas::Submap> submaps_;
};

// One robot's block in the version that counts.
struct AtlasBlock {
  RobotId robot;
  std::int32_t voxel_um = 0, truncation_um = 0;
  std::uint32_t sequence = 0;
  const SubmapBlock* block = nullptr;
};
// The latest version of every block of every robot, sorted by robot, voxel size, truncation and key.
std::vector<AtlasBlock> latest_blocks(std::span<const Atlas::Submap> submaps);

// Resamples the blocks of one robot with one voxel size (a run of latest_blocks()) into `map`: every voxel of `map`
// whose centre falls between eight observed voxels of the robot gets their trilinear mean and weight. Exact integers:
// equal on every machine; T = identity with equal voxel sizes copies.
void fuse_robot(std::span<const AtlasBlock> blocks, const QuantizedPose& T_global_robot, VoxelMap& map);

}  // namespace onemap::mapping
