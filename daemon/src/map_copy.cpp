#include "daemon/map_copy.hpp"

#include <algorithm>

namespace onemap::daemon {

namespace {
constexpr std::size_t kBytesPerBlock = 8192;  // of a voxel map's budget, more than it needs
}

mapping::VoxelMap copy_of(const mapping::VoxelMap& map) {
  mapping::VoxelMapConfig config = map.config();
  config.budget_bytes = (1u << 20) + map.used() * kBytesPerBlock;
  config.most_blocks = SIZE_MAX;
  config.image_pixels = 0;
  config.resident = false;
  mapping::VoxelMap copy(config);
  map.for_each([&](const mapping::BlockView& block) {
    mapping::Voxel* voxels = copy.find_or_add(block.key);
    if (voxels != nullptr) std::ranges::copy(block.voxels, voxels);
  });
  return copy;
}

MapCopy copy_map(const mapping::TeamMap& team) {
  MapCopy copy{team.log(), std::nullopt, std::nullopt, {}, 0};
  const mapping::SolutionRecord* solution = team.solution();
  if (solution == nullptr || team.map() == nullptr) return copy;
  copy.solution = *solution;
  copy.map.emplace(copy_of(*team.map()));
  copy.digest = team.view().digest;
  return copy;
}

}  // namespace onemap::daemon
