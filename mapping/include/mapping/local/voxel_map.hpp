#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "hal/frame.hpp"
#include "mapping/geometry.hpp"
#include "mapping/local/block_key.hpp"
#include "mapping/local/missing_blocks.hpp"
#include "mapping/local/pinhole_view.hpp"
#include "mapping/local/ray_table.hpp"
#include "mapping/local/zeroed_allocator.hpp"

namespace onemap::mapping {

// Integer accumulators: sums of observations, so adding is exact and commutes as long as no sum saturates. The
// truncated signed distance of an observation is an integer -kTsdfOne..kTsdfOne (kTsdfOne = truncation distance in
// front of the surface). 12 bytes; weight 0 means never seen.
inline constexpr std::int32_t kTsdfOne = 1000;
struct Voxel {
  static constexpr int kMaxWeight = 8388;      // kMaxWeight * kTsdfOne fits tsdf_sum
  static constexpr int kMaxColorWeight = 255;  // 255 * 255 fits rgb_sum

  std::int32_t tsdf_sum : 24 = 0;  // sum of weight * tsdf
  std::uint32_t color_weight : 8 = 0;
  std::uint16_t weight = 0;                // sum of weights
  std::array<std::uint16_t, 3> rgb_sum{};  // sum of colour over color_weight

  // |value| <= kTsdfOne, 1 <= w <= kMaxWeight / 2. At saturation what was seen is halved first, sum and weight
  // together.
  void add_tsdf(int value, int w) {
    while (weight + w > kMaxWeight) {
      tsdf_sum = tsdf_sum / 2;
      weight = static_cast<std::uint16_t>((weight + 1) / 2);  // rounded up: the mean never leaves its range
    }
    tsdf_sum = tsdf_sum + w * value;
    weight = static_cast<std::uint16_t>(weight + w);
  }
  // One observed colour (weight 1).
  void add_color(int r, int g, int b) {
    if (color_weight == kMaxColorWeight) {
      for (auto& sum : rgb_sum) sum = static_cast<std::uint16_t>(sum / 2);
      color_weight = (kMaxColorWeight + 1) / 2;
    }
    rgb_sum[0] = static_cast<std::uint16_t>(rgb_sum[0] + r);
    rgb_sum[1] = static_cast<std::uint16_t>(rgb_sum[1] + g);
    rgb_sum[2] = static_cast<std::uint16_t>(rgb_sum[2] + b);
    color_weight = (color_weight + 1u) & 0xFFu;
  }
  // Mean distance in units of the truncation / kTsdfOne, rounded to nearest; needs weight > 0.
  int tsdf() const {
    const int half = weight / 2;
    return tsdf_sum >= 0 ? (tsdf_sum + half) / weight : -((-tsdf_sum + half) / weight);
  }
  // Mean colour, rounded to nearest; black when none was seen.
  Rgb color() const {
    Rgb out{};
    if (color_weight == 0) return out;
    for (std::size_t i = 0; i < 3; ++i)
      out[i] = static_cast<std::uint8_t>((rgb_sum[i] + color_weight / 2) / color_weight);
    return out;
  }
  bool operator==(const Voxel&) const = default;
};
static_assert(sizeof(Voxel) == 12);

struct VoxelMapConfig {
  float voxel_m = 0.02f;
  float truncation_m = 0.06f;
  std::size_t budget_bytes = 48u << 20;  // everything the map ever owns, taken in the constructor
  float max_depth_m = 4.0f;              // farther readings are not fused (noise grows with the square)
  std::size_t image_pixels = 640 * 480;  // images to be fused have at most so many; 0 for a map that fuses none
  // true: every page of the budget is the map's from the start, so integrate() never waits for one; false: the budget
  // is only reserved, and the system gives pages as blocks come (for maps off the frame path).
  bool resident = true;

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

// A sparse truncated signed distance field with colour in a fixed pool of 8x8x8 blocks behind an open-addressing hash.
// Owned by one thread. No allocation after the constructor. Iteration order (sorted by key) and content are
// deterministic.
class VoxelMap {
 public:
  explicit VoxelMap(const VoxelMapConfig& config);
  static std::size_t capacity_of(const VoxelMapConfig& config);  // blocks that the budget holds

  // Fuses one frame seen from T_map_camera; rays are those of the frame's intrinsics. Colour from the frame's rgb (none
  // when empty). Points already in the map refine it and add nothing (the paper: points already observed are
  // eliminated). Only voxels within the truncation distance of a seen surface change, so free space costs nothing.
  // Allocates only when the image is larger than config.image_pixels.
  void integrate(const hal::FrameView& frame, const RayTable& rays, const Pose& T_map_camera);

  // The voxel's block, or nullptr.
  const Voxel* find(const BlockKey& key) const;
  // Finds or allocates; nullptr when the pool is full (counted).
  Voxel* find_or_add(const BlockKey& key);

  void clear();  // empty again; keeps the memory

  std::size_t capacity() const { return capacity_blocks_; }  // blocks
  std::size_t used() const { return keys_.size(); }          // blocks
  std::size_t bytes() const;
  const VoxelMapCounters& counters() const { return counters_; }
  const VoxelMapConfig& config() const { return config_; }

  // Blocks that changed since they were last handed out and that the last min_age integrations did not touch (min_age
  // 0: all changed ones), at most max_blocks, sorted by key; they count as handed out. For publishing submaps while
  // mapping.
  std::vector<BlockKey> take_settled(std::uint64_t min_age, std::size_t max_blocks);

  // All blocks, sorted by key (x, then y, then z): fn(BlockView). Allocates a sorted index (not for the frame path).
  void for_each_sorted(const std::function<void(const BlockView&)>& fn) const;
  // XXH64 of all blocks in key order, little-endian: equal content gives equal digests on every machine.
  std::uint64_t digest() const;

 private:
  struct Viewpoint;                                  // of the frame being fused
  std::int32_t index_of(const BlockKey& key) const;  // -1: not there
  std::int32_t index_or_add(const BlockKey& key);    // -1: the pool is full
  void touch(const BlockKey& key);
  void touch_seen_blocks(const Viewpoint& from);
  void touch_segment(const Vector3f& from, const Vector3f& to);
  bool fuse_block(const Viewpoint& from, std::size_t block, std::span<const std::uint8_t> rgb);
  std::vector<std::int32_t> sorted_blocks() const;

  VoxelMapConfig config_;
  std::size_t capacity_blocks_ = 0;
  VoxelMapCounters counters_;
  PinholeView view_;
  MissingBlocks missing_;
  std::vector<std::uint64_t> touched_;                 // per block: number of the integration that last touched it
  std::vector<std::uint8_t> changed_;                  // per block: 1 = not handed out since its last change
  std::vector<BlockKey> keys_;                         // key of each used block, in order of arrival
  std::vector<std::int32_t> seen_;                     // blocks touched by the frame being fused
  std::vector<Voxel, ZeroedAllocator<Voxel>> voxels_;  // pool: capacity * kBlockVoxels
  std::vector<std::int32_t> slots_;                    // hash table -> block index, -1 empty; size a power of two
};

}  // namespace onemap::mapping
