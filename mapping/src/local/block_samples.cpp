#include "local/block_samples.hpp"

#include <algorithm>
#include <bit>

namespace onemap::mapping {
namespace {

// The part of a neighbour at offset -1, 0 or 1 that lies within the margin.
struct Range {
  int from, to;
};
Range range(int offset) {
  return offset < 0 ? Range{kBlockSide - 1, kBlockSide} : (offset > 0 ? Range{0, 2} : Range{0, kBlockSide});
}

int neighbour_of(int at) { return at < 0 ? -1 : (at >= kBlockSide ? 1 : 0); }

std::size_t slot(int nx, int ny, int nz) {
  const int i = (nz + 1) * 9 + (ny + 1) * 3 + (nx + 1);
  return static_cast<std::size_t>(i);
}

// n voxels along x. In steps that the compiler makes vectors of.
template <int n, class V>
SampleRow read_row(const V* voxels, std::uint16_t min_weight, float unseen, float* out) {
  const int least = std::max<int>(min_weight, 1);
  std::array<std::uint16_t, n> seen, inside;
  for (std::size_t i = 0; i < n; ++i) {
    const bool counts = voxels[i].weight >= least;
    out[i] = counts ? mean_distance(voxels[i]) : unseen;
    seen[i] = static_cast<std::uint16_t>((counts ? 1u : 0u) << i);
    inside[i] = static_cast<std::uint16_t>((out[i] < 0 ? 1u : 0u) << i);
  }
  SampleRow row;
  for (std::size_t i = 0; i < n; ++i) {
    row.seen = static_cast<std::uint16_t>(row.seen | seen[i]);
    row.inside = static_cast<std::uint16_t>(row.inside | inside[i]);
  }
  return row;
}

}  // namespace

template <class V>
void BlockSamples<V>::gather(const BlockKey& key, const Neighbours& neighbours, std::uint16_t min_weight) {
  key_ = key;
  neighbours_ = neighbours;
  value_.fill(kUnseen);
  rows_.fill({});
  for (int nz = -1; nz <= 1; ++nz)
    for (int ny = -1; ny <= 1; ++ny)
      for (int nx = -1; nx <= 1; ++nx)
        if (const V* block = neighbours_[slot(nx, ny, nz)]) copy(nx, ny, nz, block, min_weight);
  negative_ = std::ranges::any_of(rows_, [](const SampleRow& row) { return row.inside != 0; });
  positive_ = std::ranges::any_of(rows_, [](const SampleRow& row) { return (row.seen & ~row.inside) != 0; });
  if (may_cross_zero()) guess_unseen();
}

// What three corners of a square say of the fourth, over all squares around the voxel that are seen: a + b - c is exact
// for a plane. Only direct neighbours are asked, so every block that has this voxel in its margin guesses the same.
template <class V>
float BlockSamples<V>::guess(std::size_t at) const {
  constexpr std::array<std::ptrdiff_t, 3> kStep{1, kSide, kSide * kSide};
  const auto value = [&](std::ptrdiff_t off) {
    return value_[static_cast<std::size_t>(static_cast<std::ptrdiff_t>(at) + off)];
  };
  float sum = 0;
  int squares = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = i + 1; j < 3; ++j)
      for (const std::ptrdiff_t di : {-kStep[i], kStep[i]}) {
        const float a = value(di);
        if (a >= kUnseen) continue;
        for (const std::ptrdiff_t dj : {-kStep[j], kStep[j]}) {
          const float b = value(dj), c = value(di + dj);
          if (b >= kUnseen || c >= kUnseen) continue;
          sum += a + b - c;
          ++squares;
        }
      }
  return squares == 0 ? kUnseen : std::clamp(sum / static_cast<float>(squares), -1.f, 1.f);
}

template <class V>
void BlockSamples<V>::guess_unseen() {
  struct Guess {
    std::size_t row, x;
    float value;
  };
  std::array<Guess, (kBlockSide + 1) * (kBlockSide + 1) * (kBlockSide + 1)> guesses;
  std::size_t count = 0;
  constexpr unsigned kAsked = ((1u << (kBlockSide + 1)) - 1) << 1;
  for (int z = 0; z <= kBlockSide; ++z)
    for (int y = 0; y <= kBlockSide; ++y) {
      // A square needs neighbours on two axes.
      const unsigned here = row(y, z).seen, along_x = here << 1 | here >> 1;
      const unsigned along_y = row(y - 1, z).seen | row(y + 1, z).seen;
      const unsigned along_z = row(y, z - 1).seen | row(y, z + 1).seen;
      unsigned asked = kAsked & ~here & ((along_x & (along_y | along_z)) | (along_y & along_z));
      for (; asked != 0; asked &= asked - 1) {
        const auto x = static_cast<std::size_t>(std::countr_zero(asked));
        const std::size_t at = row_index(y, z);
        const float value = guess(kSide * at + x);
        if (value < kUnseen) guesses[count++] = {at, x, value};
      }
    }
  for (std::size_t i = 0; i < count; ++i) {
    const auto& [at, x, value] = guesses[i];
    value_[kSide * at + x] = value;
    rows_[at].seen = static_cast<std::uint16_t>(rows_[at].seen | 1u << x);
    if (value < 0) rows_[at].inside = static_cast<std::uint16_t>(rows_[at].inside | 1u << x);
  }
}

template <class V>
void BlockSamples<V>::copy(int nx, int ny, int nz, const V* block, std::uint16_t min_weight) {
  const Range rx = range(nx), ry = range(ny), rz = range(nz);
  const auto first = static_cast<std::size_t>(nx * kBlockSide + rx.from + 1);
  for (int z = rz.from; z < rz.to; ++z)
    for (int y = ry.from; y < ry.to; ++y) {
      const V* from = block + (z * kBlockSide + y) * kBlockSide + rx.from;
      const std::size_t at = row_index(ny * kBlockSide + y, nz * kBlockSide + z);
      float* to = &value_[kSide * at + first];
      const int wide = rx.to - rx.from;
      const SampleRow read = wide == kBlockSide ? read_row<kBlockSide>(from, min_weight, kUnseen, to)
                             : wide == 2        ? read_row<2>(from, min_weight, kUnseen, to)
                                                : read_row<1>(from, min_weight, kUnseen, to);
      rows_[at].seen = static_cast<std::uint16_t>(rows_[at].seen | read.seen << first);
      rows_[at].inside = static_cast<std::uint16_t>(rows_[at].inside | read.inside << first);
    }
}

template <class V>
const V* BlockSamples<V>::voxel(int x, int y, int z) const {
  const V* block = neighbours_[slot(neighbour_of(x), neighbour_of(y), neighbour_of(z))];
  const int m = kBlockSide - 1;
  return block == nullptr ? nullptr : block + ((z & m) * kBlockSide + (y & m)) * kBlockSide + (x & m);
}

template <class V>
Vector3f BlockSamples<V>::gradient(int x, int y, int z) const {
  const float here = tsdf(x, y, z);
  Vector3f out;
  for (int i = 0; i < 3; ++i) {
    const int dx = i == 0 ? 1 : 0, dy = i == 1 ? 1 : 0, dz = i == 2 ? 1 : 0;
    const bool before = seen(x - dx, y - dy, z - dz), after = seen(x + dx, y + dy, z + dz);
    const float low = before ? tsdf(x - dx, y - dy, z - dz) : here, high = after ? tsdf(x + dx, y + dy, z + dz) : here;
    out[i] = before && after ? 0.5f * (high - low) : high - low;
  }
  return out;
}

template class BlockSamples<Voxel>;
template class BlockSamples<SubmapVoxel>;

}  // namespace onemap::mapping
