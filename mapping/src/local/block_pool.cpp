#include "mapping/local/block_pool.hpp"

#include <algorithm>
#include <functional>

#include "hal/base/large_pages.hpp"

namespace onemap::mapping {

namespace {
constexpr std::size_t kFewIdle = 64, kIdleShare = 64;  // blocks; one of so many that are taken
}

BlockPool::BlockPool(std::size_t blocks, bool resident) : resident_(resident) {
  voxels_.resize(blocks * kBlockVoxels);
  if (resident) make_resident(voxels_);
  states_.resize(blocks);
  free_.resize(blocks);
  for (std::size_t i = 0; i < blocks; ++i) free_[i] = static_cast<std::int32_t>(i);
}

std::size_t BlockPool::bytes_for(std::size_t blocks) {
  return blocks * (kBlockVoxels * sizeof(Voxel) + sizeof(std::int32_t) + sizeof(State));
}

std::int32_t BlockPool::take() {
  if (free_.empty()) return -1;
  std::ranges::pop_heap(free_, std::greater<>());
  const std::int32_t block = free_.back();
  free_.pop_back();
  State& state = states_[static_cast<std::size_t>(block)];
  idle_ -= state == State::written ? 1 : 0;
  if (state != State::clean) std::fill_n(voxels(block), kBlockVoxels, Voxel{});
  state = State::written;
  return block;
}

void BlockPool::give_back(std::int32_t block) {
  free_.push_back(block);
  std::ranges::push_heap(free_, std::greater<>());
  ++idle_;
}

// Neighbours together, so that the pages that they share go, too.
void BlockPool::give_back_pages() {
  if (resident_ || idle_ < std::max(kFewIdle, taken() / kIdleShare)) return;
  std::vector<std::int32_t> idle;
  idle.reserve(free_.size());
  for (const std::int32_t block : free_)
    if (states_[static_cast<std::size_t>(block)] != State::clean) idle.push_back(block);
  std::ranges::sort(idle);
  for (std::size_t first = 0, end = 0; first < idle.size(); first = end) {
    for (end = first + 1; end < idle.size() && idle[end] == idle[end - 1] + 1;) ++end;
    if (!onemap::give_back_pages(voxels(idle[first]), (end - first) * kBlockVoxels * sizeof(Voxel))) return;
  }
  for (const std::int32_t block : idle) states_[static_cast<std::size_t>(block)] = State::pages_gone;
  idle_ = 0;
}

}  // namespace onemap::mapping
