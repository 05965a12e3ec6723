#pragma once
#include <algorithm>
#include <array>
#include <cstdint>

#include "mapping/local/block_key.hpp"
#include "mapping/local/voxel.hpp"
#include "mapping/records/submap.hpp"

namespace onemap::mapping {

// What surfaces are made of, of a voxel of a map and of one that is saved or sent: its mean distance (-1..1, where
// something was seen), and its colour.
inline float mean_distance(const Voxel& voxel) {  // both are exact before the division
  return static_cast<float>(voxel.tsdf_sum) / static_cast<float>(std::max<int>(voxel.weight, 1) * kTsdfOne);
}
inline float mean_distance(const SubmapVoxel& voxel) {
  return static_cast<float>(voxel.tsdf) / static_cast<float>(kTsdfOne);
}
inline bool is_colored(const Voxel& voxel) { return voxel.color_weight > 0; }
inline bool is_colored(const SubmapVoxel& voxel) { return (voxel.rgb[0] | voxel.rgb[1] | voxel.rgb[2]) != 0; }
inline Rgb color_of(const Voxel& voxel) { return voxel.color(); }
inline Rgb color_of(const SubmapVoxel& voxel) { return voxel.rgb; }

// Voxels along x, a bit each: x = -1 is the lowest.
struct SampleRow {
  std::uint16_t seen = 0, inside = 0;
};

// A block's distances with the margin of its neighbours that surface extraction needs, so that inner loops never ask
// which block a voxel is in. Coordinates run from -1 to 9 on each axis, 0..7 is the block itself.
template <class V>
class BlockSamples {
 public:
  // The voxels of the blocks around, the block itself in the middle: x fastest, then y, then z. nullptr: not there.
  using Neighbours = std::array<const V*, 27>;

  static constexpr float kUnseen = 1e9f;

  // Gathers the block; voxels with less than min_weight are unseen. An unseen voxel of which its neighbours say what a
  // flat surface has there is taken for that: the band of a surface that is seen at a slant is thinner than a cell, and
  // it ends in half cells at each rim.
  void gather(const BlockKey& key, const Neighbours& neighbours, std::uint16_t min_weight);

  const BlockKey& key() const { return key_; }
  bool may_cross_zero() const { return negative_ && positive_; }
  SampleRow row(int y, int z) const { return rows_[row_index(y, z)]; }
  bool seen(int x, int y, int z) const { return value_[index(x, y, z)] < kUnseen; }
  float tsdf(int x, int y, int z) const { return value_[index(x, y, z)]; }  // -1..1
  bool inside(int x, int y, int z) const { return tsdf(x, y, z) < 0; }
  const V* voxel(int x, int y, int z) const;  // nullptr: not in the map
  // Towards free space; central differences where both neighbours are seen, else one-sided, else 0.
  Vector3f gradient(int x, int y, int z) const;

 private:
  static constexpr int kSide = kBlockSide + 3;
  static std::size_t index(int x, int y, int z) {
    const int i = (z + 1) * kSide * kSide + (y + 1) * kSide + (x + 1);
    return static_cast<std::size_t>(i);
  }
  static std::size_t row_index(int y, int z) { return static_cast<std::size_t>((z + 1) * kSide + (y + 1)); }
  void guess_unseen();
  float guess(std::size_t at) const;
  void copy(int nx, int ny, int nz, const V* block, std::uint16_t min_weight);

  BlockKey key_;
  bool negative_ = false, positive_ = false;
  Neighbours neighbours_{};
  std::array<float, kSide * kSide * kSide> value_{};
  std::array<SampleRow, kSide * kSide> rows_{};
};

}  // namespace onemap::mapping
