#include <algorithm>

#include "mapping/team/atlas.hpp"

namespace onemap::mapping {
namespace {

std::int32_t micrometres(float m) { return static_cast<std::int32_t>(static_cast<double>(m) * 1e6 + 0.5); }

SubmapVoxel mean_of(const Voxel& voxel) {
  SubmapVoxel out;
  if (voxel.weight == 0) return out;
  out.tsdf = static_cast<std::int16_t>(voxel.tsdf());
  out.weight = static_cast<std::uint8_t>(std::min<int>(voxel.weight, 255));
  out.rgb = voxel.color();
  if (voxel.color_weight > 0 && out.rgb == Rgb{}) out.rgb = {1, 1, 1};  // black, for 0 0 0 says that none was seen
  return out;
}

}  // namespace

SubmapRecord make_submap(const VoxelMap& map, std::span<const BlockKey> blocks) {
  SubmapRecord out;
  out.voxel_um = micrometres(map.config().voxel_m);
  out.truncation_um = micrometres(map.config().truncation_m);
  std::vector<BlockKey> keys(blocks.begin(), blocks.end());
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  for (const BlockKey& key : keys) {
    const Voxel* voxels = map.find(key);
    if (voxels == nullptr) continue;
    SubmapBlock& block = out.blocks.emplace_back();
    block.key = key;
    std::transform(voxels, voxels + kBlockVoxels, block.voxels.begin(), mean_of);
  }
  return out;
}

}  // namespace onemap::mapping
