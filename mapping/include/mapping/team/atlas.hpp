#pragma once
#include <cstdint>
#include <deque>
#include <span>
#include <tuple>
#include <vector>

#include "mapping/local/make_submap.hpp"
#include "mapping/mesh.hpp"
#include "mapping/records/submap.hpp"

namespace onemap::mapping {

// The global map as a pure function of submaps and of where they are: each is moved there and resampled into one voxel
// map with integer accumulators. Adding commutes and can be taken back, so it does not matter in which order and by
// which detours the submaps came, as long as the map is exact().
struct AtlasConfig {
  VoxelMapConfig map;  // the global map's voxel size and budget
};

struct AtlasCounters {
  std::uint64_t blocks = 0;           // of the submaps that are in, each in its latest version
  std::uint64_t blocks_left_out = 0;  // of these: voxels more than 4 times larger or smaller than the global map's
};

class Atlas {
 public:
  explicit Atlas(const AtlasConfig& config);
  struct Submap {
    std::uint32_t sequence = 0;  // of the record in its log
    const SubmapRecord* record = nullptr;
  };
  // All submaps of one anchor; their order does not matter: a block that was published again (a later sequence)
  // replaces its earlier version. The records must have passed decode_submap() (or come from make_submap()).
  struct Placed {
    QuantizedPose T_map_anchor;
    std::span<const Submap> submaps;
  };

  void clear();  // empty again
  void add(const Placed& submaps) { replace({}, submaps); }
  // Instead of `before`, which was added; costs what differs between the two. With nothing `after` it is taken away.
  void replace(const Placed& before, const Placed& after);
  void settle() { map_.drop_unseen(); }  // after what was taken away: the map is as if that had never been there
  // Nothing was refused for want of room or saturated since the map was empty. If not, what the map is depends on the
  // order: empty it and add everything in an order of its own.
  bool exact() const { return exact_; }

  const VoxelMap& map() const { return map_; }
  const AtlasCounters& counters() const { return counters_; }

 private:
  VoxelMap map_;
  AtlasCounters counters_;
  bool exact_ = true;
};

// One anchor's submaps with only those blocks that count: what was published again later is dropped as it comes, so
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
  using Place = std::tuple<std::int32_t, std::int32_t, BlockKey>;  // voxel size, truncation
  std::vector<Place> seen_;                                        // sorted
  std::deque<SubmapRecord> records_;                               // a deque: submaps_ points into it
  std::vector<Atlas::Submap> submaps_;
};

// A submap's block in the version that counts.
struct AtlasBlock {
  std::int32_t voxel_um = 0, truncation_um = 0;
  std::uint32_t sequence = 0;
  const SubmapBlock* block = nullptr;
};
// The latest version of every block of one anchor, sorted by voxel size, truncation and key.
std::vector<AtlasBlock> latest_blocks(std::span<const Atlas::Submap> submaps);

enum class Fusing { add, take_back };
// Resamples the blocks of one submap (a run of latest_blocks() that differ in their keys alone) into `map`: every voxel
// of `map` whose centre falls between eight observed voxels of the submap gets their trilinear mean and weight, or
// gives it back. Exact integers: equal on every machine; T = identity with equal voxel sizes copies. `only`: of these
// blocks alone, sorted; each with the neighbours that it needs. simd false: the plain twin of the hot loops, which
// gives the same bytes. False: something saturated or had no room.
bool fuse_submap(std::span<const AtlasBlock> blocks, const QuantizedPose& T_map_anchor, Fusing how, VoxelMap& map,
                 const std::vector<BlockKey>* only = nullptr, bool simd = true);

}  // namespace onemap::mapping
