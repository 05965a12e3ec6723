#include "mapping/local/voxel_map.hpp"

#include <xxhash.h>

#include <algorithm>
#include <array>
#include <bit>
#include <memory>
#include <utility>

#include "hal/base/bytes.hpp"
#include "local/voxel_bytes.hpp"

namespace onemap::mapping {
namespace {

constexpr std::size_t kKeyBytes = 12;
// Of one map, for each block of the pool: it may use them all.
constexpr std::size_t kOwnBytesPerBlock =
    sizeof(BlockKey) + sizeof(std::uint64_t) + sizeof(std::uint8_t) + 8 + sizeof(std::int32_t);

// At most half full, so that probing stays short.
std::size_t slots_for(std::size_t blocks) { return std::bit_ceil(2 * blocks + 2); }

// What fusing images takes beside the blocks.
std::size_t most_missing(const VoxelMapConfig& config) { return config.image_pixels > 0 ? 4096 : 0; }
std::size_t fixed_bytes(const VoxelMapConfig& config) {
  return PinholeView::bytes_for(config.image_pixels) + MissingBlocks::bytes_for(most_missing(config));
}
std::size_t shared_bytes(const VoxelMapConfig& config, std::size_t blocks) {
  return fixed_bytes(config) + BlockPool::bytes_for(blocks) + blocks * sizeof(std::int32_t);
}
std::size_t own_bytes_for(std::size_t blocks) {
  return blocks * kOwnBytesPerBlock + slots_for(blocks) * sizeof(std::int32_t);
}

}  // namespace

std::size_t VoxelMap::capacity_of(const VoxelMapConfig& config, std::size_t maps) {
  const auto bytes = [&](std::size_t blocks) { return shared_bytes(config, blocks) + maps * own_bytes_for(blocks); };
  if (config.budget_bytes <= fixed_bytes(config)) return 0;
  std::size_t blocks = (config.budget_bytes - fixed_bytes(config)) / (kBlockVoxels * sizeof(Voxel));
  while (blocks > 0 && bytes(blocks) > config.budget_bytes) --blocks;
  return std::min(blocks, config.most_blocks);
}

VoxelMap::Shared::Shared(const VoxelMapConfig& config, std::size_t maps)
    : pool(capacity_of(config, maps), config.resident), view(config.image_pixels), missing(most_missing(config)) {
  seen.reserve(pool.capacity());
}

VoxelMap::VoxelMap(const VoxelMapConfig& config, std::size_t maps)
    : VoxelMap(config, std::make_shared<Shared>(config, maps)) {}

VoxelMap::VoxelMap(const VoxelMapConfig& config, std::shared_ptr<Shared> shared)
    : config_(config), shared_(std::move(shared)) {
  const std::size_t blocks = shared_->pool.capacity();
  touched_.resize(blocks);
  changed_.resize(blocks);
  said_.resize(blocks);
  keys_.reserve(blocks);
  places_.reserve(blocks);
  slots_.assign(slots_for(blocks), -1);
}

VoxelMap VoxelMap::sibling() const { return {config_, shared_}; }

void VoxelMap::clear() {
  const std::size_t used = keys_.size();
  while (!places_.empty()) {
    shared_->pool.give_back(places_.back());
    places_.pop_back();
  }
  std::fill_n(touched_.begin(), used, 0);
  std::fill_n(changed_.begin(), used, std::uint8_t{0});
  std::fill_n(said_.begin(), used, Said{});
  std::fill(slots_.begin(), slots_.end(), -1);
  keys_.clear();
  counters_ = {};
}

// The last block takes the place of the dropped one, and the entries behind it in the hash table move up.
void VoxelMap::drop(std::size_t block) {
  const std::size_t mask = slots_.size() - 1, last = keys_.size() - 1;
  const auto slot_of = [&](std::size_t index) {
    std::size_t at = hash(keys_[index]) & mask;
    while (slots_[at] != static_cast<std::int32_t>(index)) at = (at + 1) & mask;
    return at;
  };
  std::size_t hole = slot_of(block);
  slots_[hole] = -1;
  for (std::size_t at = (hole + 1) & mask; slots_[at] >= 0; at = (at + 1) & mask) {
    const std::size_t home = hash(keys_[static_cast<std::size_t>(slots_[at])]) & mask;
    if (((at - home) & mask) < ((at - hole) & mask)) continue;  // it lies between its home and the hole's end
    slots_[hole] = std::exchange(slots_[at], -1);
    hole = at;
  }
  shared_->pool.give_back(places_[block]);
  if (block != last) {
    slots_[slot_of(last)] = static_cast<std::int32_t>(block);
    keys_[block] = keys_[last];
    places_[block] = places_[last];
    touched_[block] = touched_[last];
    changed_[block] = changed_[last];
    said_[block] = said_[last];
  }
  touched_[last] = 0;
  changed_[last] = 0;
  said_[last] = {};
  keys_.pop_back();
  places_.pop_back();
}

void VoxelMap::drop_unseen() {
  const auto seen = [](const Voxel& voxel) { return voxel.weight > 0; };
  for (std::size_t i = keys_.size(); i-- > 0;)
    if (const Voxel* voxels = voxels_of(i); std::none_of(voxels, voxels + kBlockVoxels, seen)) drop(i);
  pack();
  shared_->pool.give_back_pages();
}

// Blocks that lie beyond as many as are taken move to where there is room before: a block is a page and a half, and
// alone among free ones it holds two or three.
void VoxelMap::pack() {
  BlockPool& pool = shared_->pool;
  const auto taken = static_cast<std::int32_t>(pool.taken());
  for (std::int32_t& place : places_) {
    if (place < taken) continue;
    const std::int32_t before = pool.take();  // the lowest: as this one lies beyond, one below is free
    std::copy_n(pool.voxels(place), kBlockVoxels, pool.voxels(before));
    pool.give_back(std::exchange(place, before));
  }
}

std::size_t VoxelMap::bytes() const { return shared_bytes(config_, capacity()) + own_bytes(); }

std::size_t VoxelMap::own_bytes() const { return own_bytes_for(capacity()); }

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
  const std::int32_t place = shared_->pool.take();
  if (place < 0) return -1;
  places_.push_back(place);
  slots_[at] = static_cast<std::int32_t>(keys_.size());
  keys_.push_back(key);
  return slots_[at];
}

const Voxel* VoxelMap::find(const BlockKey& key) const {
  const std::int32_t block = index_of(key);
  return block < 0 ? nullptr : voxels_of(static_cast<std::size_t>(block));
}

Voxel* VoxelMap::find_or_add(const BlockKey& key) {
  const std::int32_t block = index_or_add(key);
  if (block < 0) {
    ++counters_.blocks_refused;
    return nullptr;
  }
  changed_[static_cast<std::size_t>(block)] = 1;
  return voxels_of(static_cast<std::size_t>(block));
}

VoxelMap::Said VoxelMap::says(std::size_t block) const {
  static_assert(sizeof(Said) == 8, "as counted in the budget");
  Said out;
  const Voxel* voxels = voxels_of(block);
  for (std::size_t i = 0; i < kBlockVoxels; ++i) {
    out.weight += voxels[i].weight;
    out.voxels = static_cast<std::uint16_t>(out.voxels + (voxels[i].weight > 0 ? 1 : 0));
  }
  return out;
}

void VoxelMap::mark_handed_out() {
  std::fill_n(changed_.begin(), keys_.size(), std::uint8_t{0});
  for (std::size_t i = 0; i < keys_.size(); ++i) said_[i] = says(i);
}

std::vector<BlockKey> VoxelMap::take_settled(std::uint64_t min_age, std::size_t max_blocks) {
  std::vector<BlockKey> out;
  for (std::size_t i = 0; i < keys_.size(); ++i)
    if (changed_[i] != 0 && counters_.integrated_frames - touched_[i] >= min_age && says(i).much_more_than(said_[i]))
      out.push_back(keys_[i]);
  std::sort(out.begin(), out.end());
  if (out.size() > max_blocks) out.resize(max_blocks);
  for (const BlockKey& key : out) {
    const auto block = static_cast<std::size_t>(index_of(key));
    changed_[block] = 0;
    said_[block] = says(block);
  }
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
    fn({keys_[block], std::span<const Voxel>(voxels_of(block), kBlockVoxels)});
  }
}

std::uint64_t VoxelMap::digest() const {
  const std::unique_ptr<XXH64_state_t, decltype(&XXH64_freeState)> state(XXH64_createState(), &XXH64_freeState);
  XXH64_reset(state.get(), 0);
  for_each_sorted([&](const BlockView& block) {
    std::array<std::uint8_t, kKeyBytes> key;
    put_little_endian(put_little_endian(put_little_endian(key.data(), block.key.x), block.key.y), block.key.z);
    XXH64_update(state.get(), key.data(), key.size());
    if constexpr (kVoxelsAreBytes) {
      XXH64_update(state.get(), block.voxels.data(), block.voxels.size_bytes());
    } else {
      std::array<std::uint8_t, kBlockVoxels * kVoxelBytes> bytes;
      voxel_bytes(block.voxels, bytes.data());
      XXH64_update(state.get(), bytes.data(), bytes.size());
    }
  });
  return XXH64_digest(state.get());
}

}  // namespace onemap::mapping
