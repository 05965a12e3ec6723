#pragma once
#include <array>
#include <cstdint>

#include "team/patch.hpp"

// The hot loops of resampling, each with its twin: where rows of the global map's voxels fall in a patch, and what the
// patch has there. Positions in the patch are integers in 1/kFraction of its voxels.
namespace onemap::mapping::cells {

inline constexpr int kFraction = 256;
inline constexpr std::uint32_t kOne = 1 << 24;  // kFraction ^ 3: the eight corners' shares add up to it
inline constexpr std::uint32_t kHalf = kOne / 2;
inline constexpr int kStride = 8;  // rows are worked on in so many voxels at once; what is beyond is waste

// A voxel of the global map that may get something: the cell of the patch that it is in, and where in it.
struct Place {
  std::uint32_t cell;       // (z * 8 + y) * 8 + x
  std::uint32_t fractions;  // x, y, z, a byte each from the lowest
  std::uint32_t number;     // of the voxel (ReachBox)
  std::uint32_t whole;      // 1: Patch::whole(). 0: on a face of the cell; corners without a share need not be observed
  int at(std::size_t axis) const { return static_cast<int>((cell >> (3 * axis)) & (kBlockSide - 1)); }
  std::uint32_t fraction(std::size_t axis) const { return (fractions >> (8 * axis)) & (kFraction - 1); }
};

// Rows of one z. The sum x + y + z + offset, in this order, is the continuous index of the source.
struct Rows {
  std::array<const double*, 3> x{}, y{};  // for each voxel of a row; for each row. Both kStride longer than they count
  std::array<double, 3> z{}, offset{};
  std::array<double, 3> from{}, to{};  // what is observed of the patch, and a little more
  std::array<double, 3> steps{};       // of x for one of the source
  std::array<double, 3> origin{};      // the patch's, in 1/kFraction
  int columns = 0, rows = 0;
  const std::uint32_t *number_x = nullptr, *number_y = nullptr;  // parts of the number, like x and y
  std::uint32_t number_z = 0;
  const std::uint32_t* whole = nullptr;  // Patch::whole_rows()
};
inline constexpr int kMostRows = 96, kMostColumns = 96;  // a block of voxels four times as large has 57
// Writes what may get something, in order, and moves `out` behind it; there must be room for all and kStride more.
void find_plain(const Rows& rows, Place*& out);
void find_simd(const Rows& rows, Place*& out);

// Trilinear sums over the eight corners, in shares of kOne, and rounded as if all had a share.
struct Sample {
  std::int64_t tsdf;
  std::array<std::uint32_t, Patch::kLanes> sums, means;  // by Patch::Lane
};
inline std::int64_t distance(const std::array<std::uint32_t, Patch::kLanes>& sums) {
  return std::int64_t{sums[Patch::kTsdfLow]} + std::int64_t{256} * sums[Patch::kTsdfHigh] -
         std::int64_t{Patch::kTsdfZero} * kOne;
}
// Of cells with all corners observed; of others the sample means nothing. The twins have sources of their own.
void blend_plain(const Patch::Voxel* voxels, const Place* places, std::size_t count, Sample* out);
void blend_simd(const Patch::Voxel* voxels, const Place* places, std::size_t count, Sample* out);

}  // namespace onemap::mapping::cells
