#include "local/block_samples.hpp"

#include <algorithm>

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

}  // namespace

void BlockSamples::gather(const VoxelMap& map, const BlockKey& key, std::uint16_t min_weight) {
  key_ = key;
  negative_ = positive_ = false;
  value_.fill(kUnseen);
  for (int nz = -1; nz <= 1; ++nz)
    for (int ny = -1; ny <= 1; ++ny)
      for (int nx = -1; nx <= 1; ++nx) {
        const Voxel* block = map.find({key.x + nx, key.y + ny, key.z + nz});
        neighbours_[slot(nx, ny, nz)] = block;
        if (block != nullptr) copy(nx, ny, nz, block, min_weight);
      }
  if (may_cross_zero()) guess_unseen();
}

// What three corners of a square say of the fourth, over all squares around the voxel that are seen: a + b - c is exact
// for a plane. Only direct neighbours are asked, so every block that has this voxel in its margin guesses the same.
float BlockSamples::guess(std::size_t at) const {
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

void BlockSamples::guess_unseen() {
  std::array<std::uint16_t, (kBlockSide + 1) * (kBlockSide + 1) * (kBlockSide + 1)> places;
  std::array<float, places.size()> guesses;
  std::size_t count = 0;
  for (int z = 0; z <= kBlockSide; ++z)
    for (int y = 0; y <= kBlockSide; ++y)
      for (int x = 0; x <= kBlockSide; ++x) {
        if (seen(x, y, z)) continue;
        const std::size_t at = index(x, y, z);
        const float value = guess(at);
        if (value >= kUnseen) continue;
        places[count] = static_cast<std::uint16_t>(at);
        guesses[count++] = value;
      }
  for (std::size_t i = 0; i < count; ++i) value_[places[i]] = guesses[i];
}

void BlockSamples::copy(int nx, int ny, int nz, const Voxel* block, std::uint16_t min_weight) {
  const Range rx = range(nx), ry = range(ny), rz = range(nz);
  for (int z = rz.from; z < rz.to; ++z)
    for (int y = ry.from; y < ry.to; ++y) {
      const Voxel* row = block + (z * kBlockSide + y) * kBlockSide;
      float* out = &value_[index(nx * kBlockSide + rx.from, ny * kBlockSide + y, nz * kBlockSide + z)];
      for (int x = rx.from; x < rx.to; ++x, ++out) {
        const Voxel& voxel = row[x];
        if (voxel.weight == 0 || voxel.weight < min_weight) continue;
        *out = static_cast<float>(voxel.tsdf_sum) / static_cast<float>(voxel.weight * kTsdfOne);
        (*out < 0 ? negative_ : positive_) = true;
      }
    }
}

const Voxel* BlockSamples::voxel(int x, int y, int z) const {
  const Voxel* block = neighbours_[slot(neighbour_of(x), neighbour_of(y), neighbour_of(z))];
  const int m = kBlockSide - 1;
  return block == nullptr ? nullptr : block + ((z & m) * kBlockSide + (y & m)) * kBlockSide + (x & m);
}

Vector3f BlockSamples::gradient(int x, int y, int z) const {
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

}  // namespace onemap::mapping
