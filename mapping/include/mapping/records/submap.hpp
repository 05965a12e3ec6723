#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "hal/base/result.hpp"
#include "mapping/local/voxel_map.hpp"

namespace onemap::mapping {

// Surface voxels of a set of blocks, as what fusion needs: tsdf mean and weight and mean colour.
struct SubmapVoxel {
  std::int16_t tsdf = 0;    // mean, in units of truncation / kTsdfOne
  std::uint8_t weight = 0;  // sum of weights, capped at 255; 0 = unseen (then everything else is 0)
  Rgb rgb{};                // mean colour; 0 0 0 = none was seen (black is written as 1 1 1)
};
struct SubmapBlock {
  BlockKey key;
  std::array<SubmapVoxel, kBlockVoxels> voxels{};
};
struct SubmapRecord {                 // lane voxels; blocks sorted by key, no key twice within one record
  std::uint32_t anchor_keyframe = 0;  // in whose frame the blocks lie; later records of it replace its earlier blocks
  std::int32_t voxel_um = 0;          // micrometres; 1 mm to 1 m
  std::int32_t truncation_um = 0;     // 1 to 100 voxels
  std::vector<SubmapBlock> blocks;    // at most 512; coordinates below 2^20
};

// In steps of a 25th of the truncation, seven weights and five bits a colour (src/records/voxel_coding.hpp),
// then compressed losslessly: what is decoded is at most half a step from what was encoded, and encodes to the same
// bytes.
std::vector<std::uint8_t> encode(const SubmapRecord& record);
// What a body says that it holds, without decompressing it: what decoding would cost is known before anything is
// decoded. The bounds of these fields and of the content's size are checked; the content is not.
struct SubmapHeader {
  std::uint32_t anchor_keyframe = 0;
  std::int32_t voxel_um = 0, truncation_um = 0;
  std::size_t blocks = 0;         // at most 512
  std::size_t content_bytes = 0;  // of the decompressed part; at most what 512 blocks need
};
Result<SubmapHeader> decode_submap_header(std::span<const std::uint8_t> body);
Result<SubmapRecord> decode_submap(std::span<const std::uint8_t> body);

}  // namespace onemap::mapping
