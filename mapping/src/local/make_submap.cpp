#include "mapping/local/make_submap.hpp"

#include <algorithm>
#include <vector>

namespace onemap::mapping {
namespace {

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
  out.voxel_um = map.config().voxel_um();
  out.truncation_um = map.config().truncation_um();
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
