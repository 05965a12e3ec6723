#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "mapping/geometry.hpp"
#include "mapping/local/block_key.hpp"
#include "mapping/local/zeroed_allocator.hpp"
#include "mapping/records/depth_grid.hpp"

namespace onemap::mapping {

struct FreeSpaceConfig {
  double cell_m = 0.05;  // 0.01 to 1
  double reach_m = 4;    // along the optical axis: farther cells have no votes, and no hits beyond 3.5 m
  std::size_t budget_bytes = 32u << 20;  // everything the grid ever owns, reserved in the constructor

  bool operator==(const FreeSpaceConfig&) const = default;
};

// What keyframes said of a cell, a vote a keyframe; both counts stop at 255.
struct CellVotes {
  std::uint8_t seen_through = 0, hit = 0;
};

enum class Space : std::uint8_t { unknown, empty, occupied };

// A surface that was hit stays, unless it was seen through four times as often (somebody who passed by); what nobody
// saw through twice and nobody hit twice is not known.
Space judged(CellVotes votes);

struct FreeSpaceCounters {
  std::uint64_t keyframes = 0;          // that voted
  std::uint64_t keyframes_refused = 0;  // no grid or no camera's, or a pose not finite or beyond 1000 km
  std::uint64_t votes_refused = 0;      // of cells for which there was no room
};

// Where is room to move: a sparse grid of cells that keyframes saw through, or hit, or never saw, from their depth
// grids. A pixel hits the cell that its point lies in. Each other cell is seen through when its middle lies before the
// surface that the pixel there shows, by more than half a cell's diagonal and three standard deviations of the depth. A
// pixel without depth says nothing. Votes are integers and are added, so any order of the keyframes gives the same
// bytes as long as nothing was refused. Used by one thread.
class FreeSpace {
 public:
  explicit FreeSpace(const FreeSpaceConfig& config);
  // Blocks of 8 x 8 x 8 cells that the budget holds.
  static std::size_t capacity_of(const FreeSpaceConfig& config);

  // The votes of one keyframe. The camera's frame is the optical one; any rigid frame will do as the map's.
  void carve(const DepthGrid& grid, const Pose& T_map_keyframe);

  // Cell (x, y, z) covers [x, x + 1) * cell_m on each axis.
  CellVotes votes(const BlockKey& cell) const;
  Space at(const Vector3d& p_map) const;
  // All blocks, sorted by key: fn(key of the block, votes of its cells, x fastest, then y, then z).
  using BlockVotes = std::span<const CellVotes, kBlockVoxels>;
  void for_each_sorted(const std::function<void(const BlockKey&, BlockVotes)>& fn) const;

  std::size_t used() const { return keys_.size(); }  // blocks
  std::size_t capacity() const { return marks_.size(); }
  std::size_t bytes() const;
  const FreeSpaceConfig& config() const { return config_; }
  const FreeSpaceCounters& counters() const { return counters_; }

 private:
  struct View;                                            // of the keyframe that votes
  using CellSet = std::array<std::uint64_t, kBlockSide>;  // bit y * 8 + x of word z
  void mark_hits(const DepthGrid& grid, const View& view);
  void see_through(const View& view);
  void see_through(const View& view, const BlockKey& key);
  std::int32_t index_of(const BlockKey& key) const;  // -1: not there
  std::int32_t index_or_add(const BlockKey& key);    // -1: no room
  CellVotes* votes_of(std::int32_t block) { return &votes_[static_cast<std::size_t>(block) * kBlockVoxels]; }
  const CellVotes* votes_of(std::int32_t block) const {
    return &votes_[static_cast<std::size_t>(block) * kBlockVoxels];
  }

  FreeSpaceConfig config_;
  FreeSpaceCounters counters_;
  std::vector<CellVotes, ZeroedAllocator<CellVotes>> votes_;
  std::vector<CellSet, ZeroedAllocator<CellSet>> marks_;  // per block: cells that the current keyframe hit
  std::vector<std::int32_t> marked_;                      // blocks with such
  std::vector<BlockKey> keys_;                            // of each used block, in order of arrival
  std::vector<std::int32_t> slots_;                       // hash table -> block, -1 empty; size a power of two
};

}  // namespace onemap::mapping
