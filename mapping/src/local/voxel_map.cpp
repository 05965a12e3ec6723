#include "mapping/local/voxel_map.hpp"

#include <xxhash.h>

#include <algorithm>
#include <bit>
#include <memory>

namespace onemap::mapping {
namespace {

constexpr std::size_t kVoxelBytes = 12;
constexpr std::size_t kBytesPerBlock = kBlockVoxels * sizeof(Voxel) + sizeof(BlockKey) + sizeof(std::uint64_t) +
                                       sizeof(std::uint8_t) + sizeof(std::int32_t);

// At most half full, so that probing stays short.
std::size_t slots_for(std::size_t blocks) { return std::bit_ceil(2 * blocks + 2); }

// What fusing images takes beside the blocks.
std::size_t most_missing(const VoxelMapConfig& config) { return config.image_pixels > 0 ? 4096 : 0; }
std::size_t fixed_bytes(const VoxelMapConfig& config) {
  return PinholeView::bytes_for(config.image_pixels) + MissingBlocks::bytes_for(most_missing(config));
}

// The voxel's content in little-endian bytes.
void put(const Voxel& voxel, std::uint8_t* out) {
  const std::uint32_t first =
      (static_cast<std::uint32_t>(voxel.tsdf_sum) & 0xFFFFFFu) | (static_cast<std::uint32_t>(voxel.color_weight) << 24);
  for (int i = 0; i < 4; ++i) out[i] = static_cast<std::uint8_t>(first >> (8 * i));
  const std::uint16_t rest[] = {voxel.weight, voxel.rgb_sum[0], voxel.rgb_sum[1], voxel.rgb_sum[2]};
  for (int i = 0; i < 8; ++i) out[4 + i] = static_cast<std::uint8_t>(rest[i / 2] >> (8 * (i % 2)));
}

void put(const BlockKey& key, std::uint8_t* out) {
  const std::int32_t axes[] = {key.x, key.y, key.z};
  for (int i = 0; i < 12; ++i)
    out[i] = static_cast<std::uint8_t>(static_cast<std::uint32_t>(axes[i / 4]) >> (8 * (i % 4)));
}

}  // namespace

std::size_t VoxelMap::capacity_of(const VoxelMapConfig& config) {
  const std::size_t fixed = fixed_bytes(config);
  if (config.budget_bytes <= fixed) return 0;
  std::size_t blocks = (config.budget_bytes - fixed) / kBytesPerBlock;
  while (blocks > 0 && fixed + blocks * kBytesPerBlock + slots_for(blocks) * sizeof(std::int32_t) > config.budget_bytes)
    --blocks;
  return blocks;
}

VoxelMap::VoxelMap(const VoxelMapConfig& config)
    : config_(config),
      capacity_blocks_(capacity_of(config)),
      view_(config.image_pixels),
      missing_(most_missing(config)) {
  touched_.resize(capacity_blocks_);
  changed_.resize(capacity_blocks_);
  keys_.reserve(capacity_blocks_);
  seen_.reserve(capacity_blocks_);
  voxels_.resize(capacity_blocks_ * kBlockVoxels);
  if (config.resident) std::fill(voxels_.begin(), voxels_.end(), Voxel{});
  slots_.assign(slots_for(capacity_blocks_), -1);
}

void VoxelMap::clear() {
  const std::size_t used = keys_.size();
  std::fill_n(voxels_.begin(), used * kBlockVoxels, Voxel{});
  std::fill_n(touched_.begin(), used, 0);
  std::fill_n(changed_.begin(), used, std::uint8_t{0});
  std::fill(slots_.begin(), slots_.end(), -1);
  keys_.clear();
  counters_ = {};
}

std::size_t VoxelMap::bytes() const {
  return view_.bytes() + MissingBlocks::bytes_for(most_missing(config_)) + capacity_blocks_ * kBytesPerBlock +
         slots_.size() * sizeof(std::int32_t);
}

std::int32_t VoxelMap::index_of(const BlockKey& key) const {
  const std::size_t mask = slots_.size() - 1;
  for (std::size_t at = hash(key) & mask;; at = (at + 1) & mask) {
    const std::int32_t block = slots_[at];
    if (block < 0 || keys_[static_cast<std::size_t>(block)] == key) return block;
  }
}

std::int32_t VoxelMap::index_or_add(const BlockKey& key) {
  const std::size_t mask = slots_.size() - 1;
  std::size_t at = hash(key) & mask;
  for (; slots_[at] >= 0; at = (at + 1) & mask)
    if (keys_[static_cast<std::size_t>(slots_[at])] == key) return slots_[at];
  if (keys_.size() == capacity_blocks_) return -1;
  slots_[at] = static_cast<std::int32_t>(keys_.size());
  keys_.push_back(key);
  return slots_[at];
}

const Voxel* VoxelMap::find(const BlockKey& key) const {
  const std::int32_t block = index_of(key);
  return block < 0 ? nullptr : &voxels_[static_cast<std::size_t>(block) * kBlockVoxels];
}

Voxel* VoxelMap::find_or_add(const BlockKey& key) {
  const std::int32_t block = index_or_add(key);
  if (block < 0) {
    ++counters_.blocks_refused;
    return nullptr;
  }
  changed_[static_cast<std::size_t>(block)] = 1;
  return &voxels_[static_cast<std::size_t>(block) * kBlockVoxels];
}

std::vector<BlockKey> VoxelMap::take_settled(std::uint64_t min_age, std::size_t max_blocks) {
  std::vector<BlockKey> out;
  for (std::size_t i = 0; i < keys_.size(); ++i)
    if (changed_[i] != 0 && counters_.integrated_frames - touched_[i] >= min_age) out.push_back(keys_[i]);
  std::sort(out.begin(), out.end());
  if (out.size() > max_blocks) out.resize(max_blocks);
  for (const BlockKey& key : out) changed_[static_cast<std::size_t>(index_of(key))] = 0;
  return out;
}

std::vector<std::int32_t> VoxelMap::sorted_blocks() const {
  std::vector<std::int32_t> order(keys_.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<std::int32_t>(i);
  std::sort(order.begin(), order.end(), [this](std::int32_t a, std::int32_t b) {
    return keys_[static_cast<std::size_t>(a)] < keys_[static_cast<std::size_t>(b)];
  });
  return order;
}

void VoxelMap::for_each_sorted(const std::function<void(const BlockView&)>& fn) const {
  for (const std::int32_t i : sorted_blocks()) {
    const auto block = static_cast<std::size_t>(i);
    fn({keys_[block], std::span<const Voxel>(&voxels_[block * kBlockVoxels], kBlockVoxels)});
  }
}

std::uint64_t VoxelMap::digest() const {
  const std::unique_ptr<XXH64_state_t, decltype(&XXH64_freeState)> state(XXH64_createState(), &XXH64_freeState);
  XXH64_reset(state.get(), 0);
  std::vector<std::uint8_t> bytes(sizeof(BlockKey) + kBlockVoxels * kVoxelBytes);
  for_each_sorted([&](const BlockView& block) {
    put(block.key, bytes.data());
    std::uint8_t* out = bytes.data() + sizeof(BlockKey);
    for (const Voxel& voxel : block.voxels) {
      put(voxel, out);
      out += kVoxelBytes;
    }
    XXH64_update(state.get(), bytes.data(), bytes.size());
  });
  return XXH64_digest(state.get());
}

}  // namespace onemap::mapping
