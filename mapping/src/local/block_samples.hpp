#pragma once
#include <array>
#include <cstdint>

#include "mapping/local/voxel_map.hpp"

namespace onemap::mapping {

// A block's distances with the margin of its neighbours that surface extraction needs, so that inner loops never ask
// which block a voxel is in. Coordinates run from -1 to 9 on each axis, 0..7 is the block itself.
class BlockSamples {
 public:
  // Gathers the block; voxels with less than min_weight are unseen. An unseen voxel of which its neighbours say what a
  // flat surface has there is taken for that: the band of a surface that is seen at a slant is thinner than a cell, and
  // it ends in half cells at each rim.
  void gather(const VoxelMap& map, const BlockKey& key, std::uint16_t min_weight);

  const BlockKey& key() const { return key_; }
  bool may_cross_zero() const { return negative_ && positive_; }
  bool seen(int x, int y, int z) const { return value_[index(x, y, z)] < kUnseen; }
  float tsdf(int x, int y, int z) const { return value_[index(x, y, z)]; }  // -1..1
  bool inside(int x, int y, int z) const { return tsdf(x, y, z) < 0; }
  const Voxel* voxel(int x, int y, int z) const;  // nullptr: not in the map
  // Towards free space; central differences where both neighbours are seen, else one-sided, else 0.
  Vector3f gradient(int x, int y, int z) const;

 private:
  static constexpr int kSide = kBlockSide + 3;
  static constexpr float kUnseen = 1e9f;
  static std::size_t index(int x, int y, int z) {
    const int i = (z + 1) * kSide * kSide + (y + 1) * kSide + (x + 1);
    return static_cast<std::size_t>(i);
  }
  void guess_unseen();
  float guess(std::size_t at) const;
  void copy(int nx, int ny, int nz, const Voxel* block, std::uint16_t min_weight);

  BlockKey key_;
  bool negative_ = false, positive_ = false;
  std::array<const Voxel*, 27> neighbours_{};
  std::array<float, kSide * kSide * kSide> value_{};
};

}  // namespace onemap::mapping
