#include "team/patch.hpp"

#include <algorithm>
#include <bit>

namespace onemap::mapping {
namespace {

// True when it is observed.
bool copy_voxel(const SubmapVoxel& v, Patch::Voxel& to, std::int16_t& tsdf) {
  const auto biased = static_cast<std::uint16_t>(v.tsdf + Patch::kTsdfZero);
  const std::uint32_t rgb = v.rgb[0] | (std::uint32_t{v.rgb[1]} << 8) | (std::uint32_t{v.rgb[2]} << 16);
  to = biased | (std::uint64_t{v.weight} << 16) | (std::uint64_t{rgb} << 24) | (std::uint64_t{rgb != 0} << 48);
  tsdf = v.tsdf;
  return v.weight != 0;
}

}  // namespace

unsigned cells::copy_row_plain(const SubmapVoxel* from, Patch::Voxel* to, std::int16_t* tsdf) {
  unsigned seen = 0;
  for (int x = 0; x < kBlockSide; ++x) seen |= (copy_voxel(from[x], to[x], tsdf[x]) ? 1u : 0u) << x;
  return seen;
}

void cells::one_surface_plain(const Patch::TsdfRow* tsdf, std::uint32_t* cells) {
  for (std::size_t z = 0; z < kBlockSide; ++z)
    for (std::size_t y = 0; y < kBlockSide; ++y) {
      std::uint32_t& bits = cells[z * kBlockSide + y] = 0;
      for (std::size_t x = 0; x < kBlockSide; ++x) {
        int least = kTsdfOne, most = -kTsdfOne;
        for (std::size_t c = 0; c < 8; ++c) {
          const int corner = tsdf[(z + c / 4) * Patch::kSide + y + c / 2 % 2][x + c % 2];
          least = std::min(least, corner);
          most = std::max(most, corner);
        }
        bits |= (most - least <= Patch::kLargestSpread ? 1u : 0u) << x;
      }
    }
}

Patch::Patch(bool simd)
    : copy_row_(simd ? cells::copy_row_simd : cells::copy_row_plain),
      one_surface_(simd ? cells::one_surface_simd : cells::one_surface_plain) {}

void Patch::gather(std::span<const AtlasBlock> blocks, std::size_t at) {
  key_ = blocks[at].block->key;
  observed_.fill(0);
  for (int n = 0; n < 8; ++n) {
    const int dx = n & 1, dy = (n >> 1) & 1, dz = n >> 2;
    const BlockKey wanted{key_.x + dx, key_.y + dy, key_.z + dz};
    std::size_t& next = next_[static_cast<std::size_t>(n)];
    while (next < blocks.size() && blocks[next].block->key < wanted) ++next;
    if (next < blocks.size() && blocks[next].block->key == wanted) copy(*blocks[next].block, dx, dy, dz);
  }
  find_bounds();
  if (!empty()) find_whole();
}

// The layers of a neighbour that touch the block; all of the block itself.
void Patch::copy(const SubmapBlock& block, int dx, int dy, int dz) {
  const auto size = [](int offset) { return offset == 0 ? kBlockSide : 1; };
  for (int z = 0; z < size(dz); ++z)
    for (int y = 0; y < size(dy); ++y) {
      const SubmapVoxel* from = &block.voxels[static_cast<std::size_t>((z * kBlockSide + y) * kBlockSide)];
      const int px = dx * kBlockSide, py = dy * kBlockSide + y, pz = dz * kBlockSide + z;
      Voxel* to = &voxels_[index(px, py, pz)];
      std::int16_t* tsdf = &tsdf_[row(py, pz)][static_cast<std::size_t>(px)];
      const unsigned seen = dx == 0 ? copy_row_(from, to, tsdf) : copy_voxel(*from, *to, *tsdf) ? 1u : 0u;
      observed_[row(py, pz)] = static_cast<std::uint16_t>(observed_[row(py, pz)] | (seen << px));
    }
}

void Patch::find_bounds() {
  low_ = {kBlockSide, kBlockSide, kBlockSide};
  high_ = {-1, -1, -1};
  unsigned columns = 0;
  for (int z = 0; z < kBlockSide; ++z)
    for (int y = 0; y < kBlockSide; ++y) {
      const unsigned seen = observed_[row(y, z)] & 0xFFu;
      if (seen == 0) continue;
      columns |= seen;
      low_[1] = std::min(low_[1], y);
      high_[1] = std::max(high_[1], y);
      low_[2] = std::min(low_[2], z);
      high_[2] = z;
    }
  if (columns == 0) return;
  low_[0] = std::countr_zero(columns);
  high_[0] = std::bit_width(columns) - 1;
}

void Patch::find_whole() {
  one_surface_(tsdf_.data(), whole_.data());
  for (int z = 0; z < kBlockSide; ++z)
    for (int y = 0; y < kBlockSide; ++y) {
      const std::uint16_t* seen = &observed_[row(y, z)];
      const unsigned all = seen[0] & seen[1] & seen[kSide] & seen[kSide + 1];
      whole_[static_cast<std::size_t>(z * kBlockSide + y)] &= all & (all >> 1);
    }
}

}  // namespace onemap::mapping
