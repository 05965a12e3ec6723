#include "mapping/local/block_pool.hpp"

#include <algorithm>

namespace onemap::mapping {

BlockPool::BlockPool(std::size_t blocks, bool resident) {
  voxels_.resize(blocks * kBlockVoxels);
  if (resident) make_resident(voxels_);
  dirty_.resize(blocks);
  free_.resize(blocks);
  for (std::size_t i = 0; i < blocks; ++i) free_[i] = static_cast<std::int32_t>(blocks - 1 - i);
}

std::size_t BlockPool::bytes_for(std::size_t blocks) {
  return blocks * (kBlockVoxels * sizeof(Voxel) + sizeof(std::int32_t) + sizeof(std::uint8_t));
}

std::int32_t BlockPool::take() {
  if (free_.empty()) return -1;
  const std::int32_t block = free_.back();
  free_.pop_back();
  std::uint8_t& dirty = dirty_[static_cast<std::size_t>(block)];
  if (dirty != 0) std::fill_n(voxels(block), kBlockVoxels, Voxel{});
  dirty = 1;
  return block;
}

void BlockPool::give_back(std::int32_t block) { free_.push_back(block); }

}  // namespace onemap::mapping
