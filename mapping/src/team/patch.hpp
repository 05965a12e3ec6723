#pragma once
#include <array>
#include <cstdint>
#include <span>

#include "mapping/team/atlas.hpp"

namespace onemap::mapping {

// A source block with the first layer of its upper neighbours: every cell that starts in the block has its eight
// corners here. Laid out for resampling: a voxel is one row of bytes, and of each cell one bit says that it counts.
class Patch {
 public:
  explicit Patch(bool simd);

  static constexpr int kSide = kBlockSide + 1;
  // Corners that differ by more straddle two surfaces; across one surface eight corners differ by sqrt(3) / 3 of it.
  static constexpr int kLargestSpread = 3 * kTsdfOne / 2;

  // The distance plus kTsdfZero, its low and its high byte, is never negative; kColored is 0 or 1.
  enum Lane : std::uint8_t { kTsdfLow, kTsdfHigh, kWeight, kRed, kGreen, kBlue, kColored, kLanes = 8 };
  static constexpr int kTsdfZero = 1024;
  static_assert(kTsdfZero >= kTsdfOne);
  using Voxel = std::uint64_t;  // a byte a lane, from the lowest
  static std::uint32_t lane(Voxel voxel, std::size_t lane) { return (voxel >> (8 * lane)) & 0xFFu; }

  using TsdfRow = std::array<std::int16_t, 16>;  // kSide of them count

  static constexpr std::size_t index(int x, int y, int z) {
    return static_cast<std::size_t>((z * kSide + y) * kSide + x);
  }

  // Block `at` of `blocks`, which are sorted by key. A patch goes through one set of blocks, from low to high.
  void gather(std::span<const AtlasBlock> blocks, std::size_t at);

  const BlockKey& key() const { return key_; }
  bool empty() const { return low_[0] > high_[0]; }
  const std::array<int, 3>& low() const {
    return low_;
  }  // bounds of what is observed in the block itself, both included
  const std::array<int, 3>& high() const { return high_; }

  const Voxel* voxels() const { return voxels_.data(); }  // by index(); only what is observed means something
  bool observed(int x, int y, int z) const { return ((observed_[row(y, z)] >> x) & 1) != 0; }
  int tsdf(int x, int y, int z) const { return tsdf_[row(y, z)][static_cast<std::size_t>(x)]; }
  // For each row of cells, z * 8 + y, bit x: all eight corners are observed and lie on one surface.
  const std::uint32_t* whole_rows() const { return whole_.data(); }

 private:
  static constexpr std::size_t row(int y, int z) { return static_cast<std::size_t>(z * kSide + y); }
  void copy(const SubmapBlock& block, int dx, int dy, int dz);
  void find_bounds();
  void find_whole();

  unsigned (*const copy_row_)(const SubmapVoxel*, Voxel*, std::int16_t*);
  void (*const one_surface_)(const TsdfRow*, std::uint32_t*);
  BlockKey key_;
  std::array<int, 3> low_{}, high_{};
  std::array<std::size_t, 8> next_{};                    // where each neighbour is looked for
  std::array<std::uint16_t, kSide * kSide> observed_{};  // by row(), a bit for each x
  std::array<std::uint32_t, kBlockSide * kBlockSide> whole_{};
  std::array<Voxel, kSide * kSide * kSide> voxels_{};
  std::array<TsdfRow, kSide * kSide> tsdf_{};  // by row()
};

namespace cells {

// A row of a block, to voxels and their distances alone; a bit for each that is observed. The twins have sources of
// their own.
unsigned copy_row_plain(const SubmapVoxel* from, Patch::Voxel* to, std::int16_t* tsdf);
unsigned copy_row_simd(const SubmapVoxel* from, Patch::Voxel* to, std::int16_t* tsdf);
// For each row of cells, z * 8 + y, bit x: its corners differ by at most kLargestSpread. `tsdf`: all rows, z * 9 + y.
void one_surface_plain(const Patch::TsdfRow* tsdf, std::uint32_t* cells);
void one_surface_simd(const Patch::TsdfRow* tsdf, std::uint32_t* cells);

}  // namespace cells
}  // namespace onemap::mapping
