#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "mapping/local/voxel.hpp"
#include "mapping/local/zeroed_allocator.hpp"

namespace onemap::mapping {

// The memory of voxel blocks: a fixed number of them, taken in the constructor, that one or several voxel maps of one
// thread share.
class BlockPool {
 public:
  // resident: every page is the pool's from the start; else the system gives pages as blocks are taken.
  BlockPool(std::size_t blocks, bool resident);

  std::size_t capacity() const { return states_.size(); }
  std::size_t free() const { return free_.size(); }
  std::size_t taken() const { return capacity() - free(); }
  std::int32_t take();                 // a block of unseen voxels; -1: none is free
  void give_back(std::int32_t block);  // whatever is in it
  // Most of what free blocks hold goes to the system, once that is much beside what is taken; of a resident pool
  // nothing.
  void give_back_pages();
  Voxel* voxels(std::int32_t block) { return &voxels_[static_cast<std::size_t>(block) * kBlockVoxels]; }
  const Voxel* voxels(std::int32_t block) const { return &voxels_[static_cast<std::size_t>(block) * kBlockVoxels]; }
  static std::size_t bytes_for(std::size_t blocks);

 private:
  std::vector<Voxel, ZeroedAllocator<Voxel>> voxels_;
  std::vector<std::int32_t> free_;  // a heap: the lowest is taken next, so that those in use stay together
  enum class State : std::uint8_t { clean, written, pages_gone };  // clean: all zero
  std::vector<State> states_;                                      // by block
  std::size_t idle_ = 0;                                           // free blocks that were written and have their pages
  bool resident_;
};

}  // namespace onemap::mapping
