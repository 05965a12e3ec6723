#pragma once
#include <cstdint>
#include <deque>
#include <set>
#include <span>
#include <tuple>
#include <vector>

#include "mapping/local/make_submap.hpp"
#include "mapping/mesh.hpp"
#include "mapping/records/solution.hpp"
#include "mapping/records/submap.hpp"

namespace onemap::mapping {

// The global map as a pure function of a record set: the robots' submaps, each moved to where its anchor is and
// resampled into one voxel map with integer accumulators. Any order of the same records gives the same bytes.
struct AtlasConfig {
  VoxelMapConfig map;  // the global map's voxel size and budget
};

struct AtlasCounters {
  std::uint64_t robots = 0;           // with submaps
  std::uint64_t blocks = 0;           // of the robots, each counted once in its latest version
  std::uint64_t blocks_left_out = 0;  // of these: voxels more than 4 times larger or smaller than the global map's,
  std::uint64_t blocks_unplaced = 0;  // or an anchor that is not known
};

class Atlas {
 public:
  explicit Atlas(const AtlasConfig& config);
  struct Submap {
    std::uint32_t sequence = 0;  // of the record in its log
    const SubmapRecord* record = nullptr;
  };
  void clear();  // empty again
  // All submaps of a robot, once a robot, robots in the order of their ids. A block that a robot published again (a
  // later sequence) replaces its earlier version. The order of the submaps does not matter; the anchors are sorted. The
  // records must have passed decode_submap() (or come from make_submap()) and live until the call returns.
  void add(std::span<const PlacedAnchor> anchors, std::span<const Submap> submaps);
  const VoxelMap& map() const { return map_; }
  const AtlasCounters& counters() const { return counters_; }

 private:
  VoxelMap map_;
  AtlasCounters counters_;
};

// One robot's submaps with only those blocks that count: what was published again later is dropped as it comes, so
// memory grows with the map and not with how often it was published, and never beyond max_blocks.
class LatestSubmaps {
 public:
  explicit LatestSubmaps(std::size_t max_blocks) : max_blocks_(max_blocks) {}
  // To be asked before a record is decoded, with the blocks that its header says it has.
  bool has_room(std::size_t blocks) const { return seen_.size() + blocks <= max_blocks_; }
  void add_older(std::uint32_t sequence, SubmapRecord record);  // in falling order of sequence
  std::span<const Atlas::Submap> submaps() const { return submaps_; }

 private:
  const std::size_t max_blocks_;
  std::set<std::tuple<std::uint32_t, std::int32_t, std::int32_t, BlockKey>> seen_;  // anchor, voxel size, truncation
  std::deque<SubmapRecord> records_;                                                // a deque: submaps_ points into it
  std::vector<Atlas::Submap> submaps_;
};

// A submap's block in the version that counts.
struct AtlasBlock {
  std::uint32_t anchor = 0;
  std::int32_t voxel_um = 0, truncation_um = 0;
  std::uint32_t sequence = 0;
  const SubmapBlock* block = nullptr;
};
// The latest version of every block, sorted by anchor, voxel size, truncation and key.
std::vector<AtlasBlock> latest_blocks(std::span<const Atlas::Submap> submaps);

// Resamples the blocks of one submap (a run of latest_blocks() that differ in their keys alone) into `map`: every voxel
// of `map` whose centre falls between eight observed voxels of the submap gets their trilinear mean and weight. Exact
// integers: equal on every machine; T = identity with equal voxel sizes copies.
void fuse_submap(std::span<const AtlasBlock> blocks, const QuantizedPose& T_map_anchor, VoxelMap& map);

}  // namespace onemap::mapping
