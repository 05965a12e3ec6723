#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "hal/frame.hpp"
#include "mapping/geometry.hpp"
#include "mapping/local/point_cloud.hpp"

namespace onemap::mapping {

// Block (x, y, z) covers [x, x+1) * 8 voxels on each axis; voxel centres are at (index + 0.5) * voxel_m.
struct BlockKey {
  std::int32_t x = 0, y = 0, z = 0;
  auto operator<=>(const BlockKey&) const = default;
};

inline constexpr int kBlockSide = 8;
inline constexpr int kBlockVoxels = kBlockSide * kBlockSide * kBlockSide;

// Integer accumulators: sums of observations, so adding is exact and commutes. The truncated signed distance of an
// observation is an integer -kTsdfOne..kTsdfOne (kTsdfOne = truncation distance in front of the surface).
inline constexpr std::int32_t kTsdfOne = 1000;
struct Voxel {
  std::int32_t tsdf_sum = 0;   // sum of weight * tsdf
  std::uint16_t weight = 0;    // sum of weights (saturates: sums are halved together when it would pass the limit)
  std::uint16_t color_weight = 0;
  std::array<std::uint32_t, 3> rgb_sum{};  // sum of colour * weight over color_weight
};

struct VoxelMapConfig {
  float voxel_m = 0.02f;
  float truncation_m = 0.06f;
  std::size_t budget_bytes = 48u << 20;  // everything the map ever owns, taken in the constructor
  float max_depth_m = 4.0f;              // farther readings are not fused (noise grows with the square)
};

struct VoxelMapCounters {
  std::uint64_t integrated_frames = 0;
  std::uint64_t blocks_refused = 0;  // the pool was full: the policy is to keep what is mapped and refuse new blocks
};

// A block as it leaves or enters the map.
struct BlockView {
  BlockKey key;
  std::span<const Voxel> voxels;  // kBlockVoxels, x fastest, then y, then z
};

// A sparse truncated signed distance field with colour in a fixed pool of 8x8x8 blocks behind an open-addressing hash.
// Owned by one thread. No allocation after the constructor. Iteration order (sorted by key) and content are deterministic.
class VoxelMap {
 public:
  explicit VoxelMap(const VoxelMapConfig& config);

  // Fuses one frame seen from T_map_camera. Colour from the frame's rgb. Points already in the map refine it and add
  // nothing (the paper: points already observed are eliminated).
  void integrate(const hal::FrameView& frame, const RayTable& rays, const Pose& T_map_camera);

  // The voxel's block, or nullptr.
  const Voxel* find(const BlockKey& key) const;
  // Finds or allocates; nullptr when the pool is full (counted).
  Voxel* find_or_add(const BlockKey& key);

  std::size_t capacity() const { return capacity_blocks_; }  // blocks
  std::size_t used() const { return keys_.size(); }          // blocks
  std::size_t bytes() const;
  const VoxelMapCounters& counters() const { return counters_; }
  const VoxelMapConfig& config() const { return config_; }

  // Blocks that changed since they were last handed out and that the last min_age integrations did not touch (min_age 0: all
  // changed ones), at most max_blocks, sorted by key; they count as handed out. For publishing submaps while mapping.
  std::vector<BlockKey> take_settled(std::uint64_t min_age, std::size_t max_blocks);

  // All blocks, sorted by key (x, then y, then z): fn(BlockView). Allocates a sorted index (not for the frame path).
  void for_each_sorted(const std::function<void(const BlockView&)>& fn) const;
  // XXH64-like 64-bit digest of all blocks in key order, little-endian: equal content gives equal digests on every machine.
  std::uint64_t digest() const;

 private:
  VoxelMapConfig config_;
  std::size_t capacity_blocks_ = 0;
  VoxelMapCounters counters_;
  std::vector<std::uint64_t> touched_;  // per block: number of the integration that last changed it
  std::vector<std::uint8_t> changed_;   // per block: 1 = not handed out since its last change
  std::vector<BlockKey> keys_;          // key of each used block, in order of arrival
  std::vector<Voxel> voxels_;           // pool: capacity * kBlockVoxels
  std::vector<std::int32_t> slots_;     // hash table -> block index, -1 empty
};

}  // namespace onemap::mapping
