#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "mapping/local/submap_anchor.hpp"
#include "mapping/local/voxel_map.hpp"
#include "mapping/local/zeroed_allocator.hpp"

namespace onemap::mapping {

// The submaps that the camera has left, as means of their observed voxels (7 bytes each), so that coming back can open
// them again. A ring of bytes taken in the constructor: when it is full, the one that was put in first goes. Nothing
// allocates after that.
class SubmapShelf {
 public:
  explicit SubmapShelf(std::size_t budget_bytes);

  // False: it is larger than the shelf.
  bool put(const SubmapAnchor& anchor, const VoxelMap& voxels);
  bool has(std::uint32_t anchor) const { return find(anchor).has_value(); }
  bool take(std::uint32_t anchor, VoxelMap& into);  // into an empty map, as handed out; false: it is not here
  std::size_t blocks(std::uint32_t anchor) const;   // that it has; 0: it is not here
  void place(const SubmapAnchor& anchor);           // the anchor has moved
  // Oldest first. `scratch` holds one submap at a time.
  void for_each(VoxelMap& scratch, const std::function<void(const SubmapAnchor&, const VoxelMap&)>& fn) const;
  std::uint64_t dropped() const { return dropped_; }  // for want of room
  std::size_t bytes() const { return ring_.size(); }

 private:
  struct Entry {
    SubmapAnchor anchor;
    std::size_t blocks = 0, begin = 0, bytes = 0;  // from begin, in the ring
    bool taken = false;                            // out again; its bytes wait for their turn to be used anew
  };
  static constexpr std::size_t kMostEntries = 1024;
  std::optional<std::size_t> find(std::uint32_t anchor) const;  // in entries_
  const Entry& entry(std::size_t i) const { return entries_[(first_ + i) % kMostEntries]; }
  std::optional<std::size_t> place_for(std::size_t bytes) const;
  void drop_oldest();
  void restore(const Entry& entry, VoxelMap& into) const;

  std::vector<std::uint8_t, ZeroedAllocator<std::uint8_t>> ring_;
  std::vector<Entry> entries_;  // a ring, too: count_ from first_, in order of arrival
  std::size_t first_ = 0, count_ = 0;
  std::size_t end_ = 0;  // behind the youngest
  std::uint64_t dropped_ = 0;
};

}  // namespace onemap::mapping
