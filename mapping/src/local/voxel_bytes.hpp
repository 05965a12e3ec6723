#pragma once
#include <bit>
#include <cstdint>
#include <span>

#include "hal/base/bytes.hpp"
#include "mapping/local/voxel.hpp"

namespace onemap::mapping {

inline constexpr std::size_t kVoxelBytes = 12;

// What a digest is taken of: the sum's 24 bits and the colour's weight above them, the weight, the colours' sums; each
// the lowest byte first.
inline void voxel_bytes(std::span<const Voxel> voxels, std::uint8_t* out) {
  for (const Voxel& voxel : voxels) {
    const std::uint32_t sum = static_cast<std::uint32_t>(voxel.tsdf_sum) & 0xFFFFFFu;
    out = put_little_endian(out, sum | (std::uint32_t{voxel.color_weight} << 24));
    out = put_little_endian(out, voxel.weight);
    for (const std::uint16_t color : voxel.rgb_sum) out = put_little_endian(out, color);
  }
}

// A voxel stands in memory as these bytes: every compiler for little-endian machines that we know lays out bit fields
// from the lowest bit; a test compares.
inline constexpr bool kVoxelsAreBytes = std::endian::native == std::endian::little && sizeof(Voxel) == kVoxelBytes;

}  // namespace onemap::mapping
