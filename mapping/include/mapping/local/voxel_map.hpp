#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "hal/frame.hpp"
#include "mapping/geometry.hpp"
#include "mapping/local/block_pool.hpp"
#include "mapping/local/missing_blocks.hpp"
#include "mapping/local/pinhole_view.hpp"
#include "mapping/local/ray_table.hpp"
#include "mapping/local/voxel.hpp"

namespace onemap::mapping {

struct VoxelMapConfig {
  float voxel_m = 0.02f;
  float truncation_m = 0.06f;
  std::size_t budget_bytes = 48u << 20;  // everything the map ever owns, taken in the constructor
  std::size_t most_blocks = SIZE_MAX;    // of what the budget holds no more are used
  float max_depth_m = 4.0f;              // farther readings are not fused (noise grows with the square)
  std::size_t image_pixels = 640 * 480;  // images to be fused have at most so many; 0 for a map that fuses none
  // true: every page of the budget is the map's from the start, so integrate() never waits for one; false: the budget
  // is only reserved, and the system gives pages as blocks come (for maps off the frame path).
  bool resident = true;
  bool simd = true;  // false: the plain reference, which fuses the same bytes

  std::int32_t voxel_um() const { return static_cast<std::int32_t>(std::lround(static_cast<double>(voxel_m) * 1e6)); }
  std::int32_t truncation_um() const {
    return static_cast<std::int32_t>(std::lround(static_cast<double>(truncation_m) * 1e6));
  }
};

struct VoxelMapCounters {
  std::uint64_t integrated_frames = 0;
  // The pool was full: what is mapped is kept, new blocks are refused. An integration counts each block that it misses
  // once (at most 4096), find_or_add() each call.
  std::uint64_t blocks_refused = 0;
  std::uint64_t frames_short = 0;    // integrations that missed a block
  std::uint64_t frames_refused = 0;  // the pose was not finite, or more than 1000 km away
};

// A block as it leaves or enters the map.
struct BlockView {
  BlockKey key;
  std::span<const Voxel> voxels;  // kBlockVoxels, x fastest, then y, then z
};

// A sparse truncated signed distance field with colour: 8x8x8 blocks of a fixed pool behind an open-addressing hash.
// Owned by one thread. No allocation after the constructor. Iteration order (sorted by key) and content are
// deterministic. Several maps of one thread may share a pool (and what fusing images needs): sibling().
class VoxelMap {
 public:
  // A map with a pool of its own. `maps`: so many will share it, itself included; they keep the budget together.
  explicit VoxelMap(const VoxelMapConfig& config, std::size_t maps = 1);
  VoxelMap(VoxelMap&&) = default;
  VoxelMap& operator=(VoxelMap&&) = default;
  VoxelMap sibling() const;  // an empty map in the same pool
  // Blocks that the budget holds.
  static std::size_t capacity_of(const VoxelMapConfig& config, std::size_t maps = 1);

  // Fuses one frame seen from T_map_camera; rays are those of the frame's intrinsics. Colour from the frame's rgb (none
  // when empty). Points already in the map refine it and add nothing (the paper: points already observed are
  // eliminated). Only voxels within the truncation distance of a seen surface change, so free space costs nothing.
  // Allocates only when the image is larger than config.image_pixels.
  void integrate(const hal::FrameView& frame, const RayTable& rays, const Pose& T_map_camera);

  // The voxel's block, or nullptr.
  const Voxel* find(const BlockKey& key) const;
  // Finds or allocates; nullptr when the pool is full (counted).
  Voxel* find_or_add(const BlockKey& key);
  void mark_handed_out();  // as it is now: what take_settled() will give changed later

  void clear();        // empty again; its blocks are the pool's
  void drop_unseen();  // gives back the blocks without an observed voxel, and the pages that nobody needs then

  std::size_t capacity() const { return shared_->pool.capacity(); }  // blocks, of the pool
  std::size_t room() const { return shared_->pool.free(); }          // of these, that nobody uses
  std::size_t used() const { return keys_.size(); }                  // blocks, by this map
  std::size_t bytes() const;                                         // with the pool
  std::size_t own_bytes() const;                                     // without what siblings share
  const VoxelMapCounters& counters() const { return counters_; }
  const VoxelMapConfig& config() const { return config_; }

  // Blocks that were never handed out, or say clearly more than then (a quarter more voxels, or thrice the weight), and
  // that the last min_age integrations did not touch (min_age 0: whenever), at most max_blocks, sorted by key; they
  // count as handed out. For publishing submaps while mapping: each version of a block costs bytes on every link.
  std::vector<BlockKey> take_settled(std::uint64_t min_age, std::size_t max_blocks);

  // All blocks, in order of arrival: fn(BlockView).
  template <class Fn>
  void for_each(Fn&& fn) const {
    for (std::size_t i = 0; i < keys_.size(); ++i) fn(BlockView{keys_[i], {voxels_of(i), kBlockVoxels}});
  }
  // All blocks, sorted by key (x, then y, then z): fn(BlockView). Allocates a sorted index (not for the frame path).
  void for_each_sorted(const std::function<void(const BlockView&)>& fn) const;
  // XXH64 of all blocks in key order, little-endian: equal content gives equal digests on every machine.
  std::uint64_t digest() const;

 private:
  struct Said {  // how much a block says
    std::uint32_t weight = 0;
    std::uint16_t voxels = 0;
    bool much_more_than(const Said& before) const {
      return voxels > 0 && (before.voxels == 0 || 4 * voxels >= 5 * before.voxels || weight >= 3 * before.weight);
    }
  };
  Said says(std::size_t block) const;
  struct Viewpoint;                                  // of the frame being fused
  std::int32_t index_of(const BlockKey& key) const;  // -1: not there
  std::int32_t index_or_add(const BlockKey& key);    // -1: the pool is full
  void drop(std::size_t block);
  void pack();
  void touch(const BlockKey& key);
  void touch_seen_blocks(const Viewpoint& from);
  void touch_segment(const Vector3f& from, const Vector3f& to);
  Viewpoint viewpoint(const hal::FrameView& frame, const Pose& T_map_camera) const;
  bool fuse_block(const Viewpoint& from, std::size_t block);
  std::vector<std::int32_t> sorted_blocks() const;

  Voxel* voxels_of(std::size_t block) { return shared_->pool.voxels(places_[block]); }
  const Voxel* voxels_of(std::size_t block) const { return shared_->pool.voxels(places_[block]); }

  // What sibling maps have in common.
  struct Shared {
    Shared(const VoxelMapConfig& config, std::size_t maps);
    BlockPool pool;
    PinholeView view;
    MissingBlocks missing;
    std::vector<std::int32_t> seen;   // blocks touched by the frame being fused
    std::array<BlockKey, 64> lately;  // some of them: rays next to each other pass the same ones
  };
  VoxelMap(const VoxelMapConfig& config, std::shared_ptr<Shared> shared);

  VoxelMapConfig config_;
  std::shared_ptr<Shared> shared_;
  VoxelMapCounters counters_;
  std::vector<std::uint64_t> touched_;  // per block: number of the integration that last touched it
  std::vector<std::uint8_t> changed_;   // per block: 1 = not handed out since its last change
  std::vector<Said> said_;              // per block: when it was last handed out; zeros: never
  std::vector<BlockKey> keys_;          // key of each used block, in order of arrival
  std::vector<std::int32_t> places_;    // of each used block, in the pool
  std::vector<std::int32_t> slots_;     // hash table -> block index, -1 empty; size a power of two
};

}  // namespace onemap::mapping
