#pragma once
#include <compare>
#include <cstddef>
#include <cstdint>

namespace onemap::mapping {

// Block (x, y, z) covers [x, x+1) * 8 voxels on each axis; voxel centres are at (index + 0.5) * voxel_m.
struct BlockKey {
  std::int32_t x = 0, y = 0, z = 0;
  auto operator<=>(const BlockKey&) const = default;
};

inline constexpr int kBlockSide = 8;
inline constexpr int kBlockVoxels = kBlockSide * kBlockSide * kBlockSide;

inline std::size_t hash(const BlockKey& key) {
  std::uint64_t h = static_cast<std::uint32_t>(key.x) * 0x9E3779B97F4A7C15u;
  h ^= static_cast<std::uint32_t>(key.y) * 0xC2B2AE3D27D4EB4Fu;
  h ^= static_cast<std::uint32_t>(key.z) * 0x165667B19E3779F9u;
  return static_cast<std::size_t>(((h ^ (h >> 32)) * 0x9E3779B97F4A7C15u) >> 20);
}

}  // namespace onemap::mapping
