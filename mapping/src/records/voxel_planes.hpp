#pragma once
#include <array>
#include <cstdint>
#include <span>

#include "records/voxel_coding.hpp"

namespace onemap::mapping {

// The voxels of a submap as they stand on the wire (submap.cpp): masks with a bit a voxel, the first voxel's lowest,
// and the changes beside what is expected, a byte each. `colored` counts observed voxels, the last three channels
// coloured ones. The sizes must fit together.
struct VoxelPlanes {
  std::span<const std::uint8_t> seen, colored;
  std::array<std::span<const std::uint8_t>, kVoxelChannels> channels;
};

// Undoes what VoxelPredictor and to_steps() made, a row at a time. The blocks must be as they come: unseen. False:
// steps that no voxel has.
bool decode_voxels(const VoxelPlanes& planes, std::span<SubmapBlock> blocks);

}  // namespace onemap::mapping
