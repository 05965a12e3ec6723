#include "mapping/team/free_space.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "floor_int.hpp"
#include "team/grid_view.hpp"

namespace onemap::mapping {
namespace {

constexpr double kFarthestPose_m = 1e6;
constexpr double kWidestView = 4;  // of half the view, sideways against ahead
// Three standard deviations are 6 cm there; of farther floors some cells would look like things that stand on them.
constexpr double kFarthestHit_m = 3.5;
constexpr int kMostVotes = 255;
constexpr int kSeenThroughForAHit = 4, kLeastVotes = 2;

constexpr std::size_t kBytesPerBlock =
    kBlockVoxels * sizeof(CellVotes) + kBlockSide * sizeof(std::uint64_t) + sizeof(std::int32_t) + sizeof(BlockKey);

// At most half full, so that probing stays short.
std::size_t slots_for(std::size_t blocks) { return std::bit_ceil(2 * blocks + 2); }
std::size_t bytes_for(std::size_t blocks) { return blocks * kBytesPerBlock + slots_for(blocks) * sizeof(std::int32_t); }

void add_vote(std::uint8_t& votes) { votes = static_cast<std::uint8_t>(votes + (votes < kMostVotes ? 1 : 0)); }

// A view of more than 76 degrees to a side is none that a depth camera has, and its far end would be anywhere.
bool is_view(double size, std::int32_t focal, std::int32_t centre) {
  const double f = focal / 1024.0, c = centre / 1024.0;
  return f > 0 && c + 0.5 < kWidestView * f && size - 0.5 - c < kWidestView * f;
}

bool usable(const DepthGrid& grid, const Pose& T) {
  const std::size_t cells = static_cast<std::size_t>(grid.width) * grid.height;
  const auto& k = grid.fx_fy_cx_cy;
  return cells > 0 && grid.inverse_depth.size() == cells && is_view(grid.width, k[0], k[2]) &&
         is_view(grid.height, k[1], k[3]) && T.R.allFinite() && T.t.allFinite() &&
         T.t.cwiseAbs().maxCoeff() < kFarthestPose_m;
}

int cell_index(const BlockKey& cell) {
  constexpr int kMask = kBlockSide - 1;
  return ((cell.z & kMask) * kBlockSide + (cell.y & kMask)) * kBlockSide + (cell.x & kMask);
}
BlockKey block_of(const BlockKey& cell) { return {cell.x >> 3, cell.y >> 3, cell.z >> 3}; }

BlockKey cell_of(const Vector3d& p, double cells_per_m) {
  return {floor_int<std::int32_t>(p.x() * cells_per_m), floor_int<std::int32_t>(p.y() * cells_per_m),
          floor_int<std::int32_t>(p.z() * cells_per_m)};
}

}  // namespace

Space judged(CellVotes votes) {
  const bool hit = votes.hit >= kLeastVotes && votes.seen_through <= kSeenThroughForAHit * votes.hit;
  if (hit) return Space::occupied;
  return votes.seen_through >= kLeastVotes && votes.seen_through > kSeenThroughForAHit * votes.hit ? Space::empty
                                                                                                   : Space::unknown;
}

struct FreeSpace::View : GridView {
  using GridView::GridView;
};

std::size_t FreeSpace::capacity_of(const FreeSpaceConfig& config) {
  std::size_t blocks = config.budget_bytes / kBytesPerBlock;
  while (blocks > 0 && bytes_for(blocks) > config.budget_bytes) --blocks;
  return blocks;
}

FreeSpace::FreeSpace(const FreeSpaceConfig& config) : config_(config) {
  const std::size_t blocks = capacity_of(config);
  votes_.resize(blocks * kBlockVoxels);
  marks_.resize(blocks);
  marked_.reserve(blocks);
  keys_.reserve(blocks);
  slots_.assign(slots_for(blocks), -1);
}

std::size_t FreeSpace::bytes() const { return bytes_for(capacity()); }

void FreeSpace::carve(const DepthGrid& grid, const Pose& T_map_keyframe) {
  if (!usable(grid, T_map_keyframe)) {
    ++counters_.keyframes_refused;
    return;
  }
  ++counters_.keyframes;
  const View view(grid, T_map_keyframe, config_);
  mark_hits(grid, view);
  see_through(view);
  for (const std::int32_t block : marked_) marks_[static_cast<std::size_t>(block)] = {};
  marked_.clear();
}

void FreeSpace::mark_hits(const DepthGrid& grid, const View& view) {
  const double cells_per_m = 1 / config_.cell_m, farthest_m = std::min(config_.reach_m, kFarthestHit_m);
  BlockKey last_key;
  std::int32_t block = -1;
  std::size_t pixel = 0;
  for (int v = 0; v < view.height; ++v) {
    for (int u = 0; u < view.width; ++u, ++pixel) {
      const double z = grid_depth_m(grid.inverse_depth[pixel]);
      if (z <= 0 || z > farthest_m) continue;
      const Vector3d p(z * (u - view.cx) / view.fx, z * (v - view.cy) / view.fy, z);
      const BlockKey cell = cell_of(view.T_map_camera * p, cells_per_m), key = block_of(cell);
      if (block < 0 || key != last_key) block = index_or_add(key);
      last_key = key;
      if (block < 0) {
        ++counters_.votes_refused;
        continue;
      }
      CellSet& marks = marks_[static_cast<std::size_t>(block)];
      if (marks == CellSet{}) marked_.push_back(block);
      const auto index = static_cast<std::size_t>(cell_index(cell));
      std::uint64_t& word = marks[index / 64];
      if ((word >> (index % 64) & 1) != 0) continue;  // one vote a keyframe
      word |= std::uint64_t{1} << (index % 64);
      add_vote(votes_of(block)[index].hit);
    }
  }
}

void FreeSpace::see_through(const View& view) {
  Vector3d low = view.T_map_camera.t, high = low;
  for (const Vector3d& corner : view.corners()) {
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  }
  const double blocks_per_m = 1 / (config_.cell_m * kBlockSide);
  const BlockKey first = cell_of(low, blocks_per_m), last = cell_of(high, blocks_per_m);
  for (std::int32_t z = first.z; z <= last.z; ++z)
    for (std::int32_t y = first.y; y <= last.y; ++y)
      for (std::int32_t x = first.x; x <= last.x; ++x) see_through(view, {x, y, z});
}

void FreeSpace::see_through(const View& view, const BlockKey& key) {
  const double cell = config_.cell_m, side = cell * kBlockSide;
  const Matrix3d R_camera_map = view.T_map_camera.R.transpose();
  const Vector3d corner = R_camera_map * (side * Vector3d(key.x, key.y, key.z) - view.T_map_camera.t);
  if (!view.sees(corner + R_camera_map * Vector3d::Constant(side / 2), kHalfDiagonal * side)) return;
  const Eigen::Matrix3f step = (R_camera_map * cell).cast<float>();
  const Eigen::Vector3f first = corner.cast<float>() + step * Eigen::Vector3f::Constant(0.5f);
  CellSet through{};
  std::uint64_t any = 0;
  for (int z = 0; z < kBlockSide; ++z) {
    std::uint64_t layer = 0;
    for (int y = 0; y < kBlockSide; ++y) {
      const Eigen::Vector3f row = first + static_cast<float>(y) * step.col(1) + static_cast<float>(z) * step.col(2);
      layer |= std::uint64_t{view.row_through(row, step.col(0))} << (kBlockSide * y);
    }
    through[static_cast<std::size_t>(z)] = layer;
    any |= layer;
  }
  if (any == 0) return;
  const std::int32_t block = index_or_add(key);
  for (std::size_t z = 0; z < kBlockSide; ++z) {
    if (block < 0) {
      counters_.votes_refused += static_cast<std::uint64_t>(std::popcount(through[z]));
      continue;
    }
    CellVotes* votes = votes_of(block) + 64 * z;
    for (std::uint64_t left = through[z] & ~marks_[static_cast<std::size_t>(block)][z]; left != 0; left &= left - 1)
      add_vote(votes[std::countr_zero(left)].seen_through);
  }
}

CellVotes FreeSpace::votes(const BlockKey& cell) const {
  const std::int32_t block = index_of(block_of(cell));
  return block < 0 ? CellVotes{} : votes_of(block)[cell_index(cell)];
}

Space FreeSpace::at(const Vector3d& p_map) const {
  if (!(p_map.cwiseAbs().maxCoeff() < kFarthestPose_m)) return Space::unknown;
  return judged(votes(cell_of(p_map, 1 / config_.cell_m)));
}

void FreeSpace::for_each_sorted(const std::function<void(const BlockKey&, BlockVotes)>& fn) const {
  std::vector<std::int32_t> order(keys_.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](std::int32_t block) { return keys_[static_cast<std::size_t>(block)]; });
  for (const std::int32_t block : order)
    fn(keys_[static_cast<std::size_t>(block)], BlockVotes(votes_of(block), kBlockVoxels));
}

std::int32_t FreeSpace::index_of(const BlockKey& key) const {
  const std::size_t mask = slots_.size() - 1;
  for (std::size_t at = hash(key) & mask;; at = (at + 1) & mask) {
    const std::int32_t block = slots_[at];
    if (block < 0 || keys_[static_cast<std::size_t>(block)] == key) return block;
  }
}

std::int32_t FreeSpace::index_or_add(const BlockKey& key) {
  const std::size_t mask = slots_.size() - 1;
  std::size_t at = hash(key) & mask;
  for (; slots_[at] >= 0; at = (at + 1) & mask)
    if (keys_[static_cast<std::size_t>(slots_[at])] == key) return slots_[at];
  if (keys_.size() == capacity()) return -1;
  slots_[at] = static_cast<std::int32_t>(keys_.size());
  keys_.push_back(key);
  return slots_[at];
}

}  // namespace onemap::mapping
