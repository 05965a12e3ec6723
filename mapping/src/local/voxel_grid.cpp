#include "mapping/local/voxel_grid.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <optional>

#include "floor_int.hpp"

namespace onemap::mapping {
namespace {

constexpr std::uint32_t kFree = 0;
constexpr int kCoordinateBits = 21;
constexpr std::int32_t kOffset = 1 << (kCoordinateBits - 1);

// x, y, z of the voxel, most significant first, so that keys sort like (x, y, z). None outside +-2^20 (and for NaN).
std::optional<std::uint64_t> voxel_key(const Vector3f& p, float per_leaf) {
  constexpr float kLimit = kOffset;
  std::uint64_t key = 0;
  for (int i = 0; i < 3; ++i) {
    const float c = p[i] * per_leaf;
    if (!(c >= -kLimit && c < kLimit)) return std::nullopt;
    key = (key << kCoordinateBits) | static_cast<std::uint64_t>(floor_int<std::int32_t>(c) + kOffset);
  }
  return key;
}

}  // namespace

VoxelGrid::VoxelGrid(float leaf_m, std::size_t max_points)
    : leaf_m_(leaf_m),
      max_points_(max_points),
      cells_(max_points),
      order_(max_points),
      slots_(std::bit_ceil(2 * max_points + 1), kFree) {}

std::size_t VoxelGrid::bytes() const {
  return cells_.capacity() * sizeof(Cell) + order_.capacity() * sizeof(Order) +
         slots_.capacity() * sizeof(std::uint32_t);
}

// Open addressing; a slot holds the number of its cell + 1.
VoxelGrid::Cell& VoxelGrid::cell_of(std::uint64_t key) {
  const std::size_t mask = slots_.size() - 1;
  std::size_t slot = static_cast<std::size_t>((key * 0x9E3779B97F4A7C15u) >> 32) & mask;
  for (;; slot = (slot + 1) & mask) {
    if (slots_[slot] == kFree) {
      Cell& cell = cells_[used_++];
      cell = Cell{.key = key, .slot = static_cast<std::uint32_t>(slot)};
      slots_[slot] = static_cast<std::uint32_t>(used_);
      return cell;
    }
    Cell& cell = cells_[slots_[slot] - 1];
    if (cell.key == key) return cell;
  }
}

std::size_t VoxelGrid::downsample(std::span<const Vector3f> in, std::span<Vector3f> out) {
  assert(in.size() <= max_points_);
  const float per_leaf = 1 / leaf_m_;
  used_ = 0;
  Cell* cell = nullptr;
  for (const Vector3f& p : in) {
    const auto key = voxel_key(p, per_leaf);
    if (!key) continue;
    if (cell == nullptr || cell->key != *key) cell = &cell_of(*key);  // neighbours in an image share their voxel
    cell->x += p.x();
    cell->y += p.y();
    cell->z += p.z();
    ++cell->count;
  }
  for (std::size_t i = 0; i < used_; ++i) {
    order_[i] = {cells_[i].key, static_cast<std::uint32_t>(i)};
    slots_[cells_[i].slot] = kFree;
  }
  std::sort(order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(used_),
            [](const Order& a, const Order& b) { return a.key < b.key; });
  const std::size_t n = std::min(used_, out.size());
  for (std::size_t i = 0; i < n; ++i) {
    const Cell& c = cells_[order_[i].cell];
    const double share = 1.0 / c.count;
    out[i] = {static_cast<float>(c.x * share), static_cast<float>(c.y * share), static_cast<float>(c.z * share)};
  }
  return n;
}

}  // namespace onemap::mapping
