// Moves one submap's voxels into the global map. Positions are doubles from + - * / in an order that is written out; at
// once they become integers in 1/256 of a source voxel, and everything after that is integer arithmetic.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "floor_int.hpp"
#include "mapping/team/atlas.hpp"

namespace onemap::mapping {
namespace {

constexpr int kFraction = 256;
constexpr std::int64_t kOne = 1 << 24;  // kFraction ^ 3: the eight corners' shares add up to it
constexpr int kPatchSide = kBlockSide + 1;
// Corners that differ by more straddle two surfaces; across one surface eight corners differ by sqrt(3) / 3 of it.
constexpr int kLargestSpread = 3 * kTsdfOne / 2;

std::int64_t rounded_ratio(std::int64_t a, std::int64_t b) { return a >= 0 ? (a + b / 2) / b : -((-a + b / 2) / b); }

// From indices of the global map to continuous indices of the submap's voxels: s = A (g + 0.5) + b.
struct Grid {
  std::array<std::array<double, 3>, 3> A{};
  std::array<double, 3> b{};
  Pose T_map_anchor;
  double source_m = 0, global_m = 0;

  Grid(const QuantizedPose& pose, std::int32_t source_um, std::int32_t global_um)
      : T_map_anchor(from_quantized(pose)), source_m(source_um * 1e-6), global_m(global_um * 1e-6) {
    const double scale = static_cast<double>(global_um) / source_um;
    for (std::size_t i = 0; i < 3; ++i) {
      double along = 0;  // the anchor's axis i over the translation, in units of 10 micrometres
      for (std::size_t j = 0; j < 3; ++j) {
        const double r = T_map_anchor.R(static_cast<int>(j), static_cast<int>(i));
        A[i][j] = r * scale;
        along = along + r * pose.t_10um[j];
      }
      b[i] = -(along * 10 / source_um) - 0.5;
    }
  }
  double at(std::size_t i, double gx, double gy, double gz) const {
    return A[i][0] * (gx + 0.5) + A[i][1] * (gy + 0.5) + A[i][2] * (gz + 0.5) + b[i];
  }
};

// A source block with the first layer of its upper neighbours: every cell that starts in the block is complete.
struct Patch {
  BlockKey key;
  std::array<SubmapVoxel, kPatchSide * kPatchSide * kPatchSide> voxels{};
  std::array<int, 3> low{}, high{};  // bounds of what is observed in the block itself; empty: low > high

  static std::size_t index(int x, int y, int z) {
    const int i = (z * kPatchSide + y) * kPatchSide + x;
    return static_cast<std::size_t>(i);
  }

  void gather(std::span<const AtlasBlock> blocks, const SubmapBlock& centre) {
    key = centre.key;
    voxels.fill({});
    low = {kBlockSide, kBlockSide, kBlockSide};
    high = {-1, -1, -1};
    for (int n = 0; n < 8; ++n) {
      const std::array<int, 3> d{n & 1, (n >> 1) & 1, n >> 2};
      const SubmapBlock* block = n == 0 ? &centre : find(blocks, {key.x + d[0], key.y + d[1], key.z + d[2]});
      if (block != nullptr) copy(*block, d);
    }
    for (int i = 0; i < kBlockVoxels; ++i) {
      if (centre.voxels[static_cast<std::size_t>(i)].weight == 0) continue;
      const std::array<int, 3> at{i % kBlockSide, i / kBlockSide % kBlockSide, i / (kBlockSide * kBlockSide)};
      for (std::size_t k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], at[k]);
        high[k] = std::max(high[k], at[k]);
      }
    }
  }

 private:
  static const SubmapBlock* find(std::span<const AtlasBlock> blocks, const BlockKey& key) {
    const auto at = std::lower_bound(blocks.begin(), blocks.end(), key,
                                     [](const AtlasBlock& a, const BlockKey& k) { return a.block->key < k; });
    return at != blocks.end() && at->block->key == key ? at->block : nullptr;
  }
  void copy(const SubmapBlock& block, const std::array<int, 3>& d) {
    const auto size = [](int offset) { return offset == 0 ? kBlockSide : 1; };
    for (int z = 0; z < size(d[2]); ++z)
      for (int y = 0; y < size(d[1]); ++y)
        for (int x = 0; x < size(d[0]); ++x) {
          const int i = (z * kBlockSide + y) * kBlockSide + x;
          voxels[index(d[0] * kBlockSide + x, d[1] * kBlockSide + y, d[2] * kBlockSide + z)] =
              block.voxels[static_cast<std::size_t>(i)];
        }
  }
};

struct Sample {
  std::int64_t tsdf = 0, weight = 0;  // times kOne
  std::array<std::int64_t, 3> rgb{};  // times color
  std::int64_t color = 0;             // share of the corners with colour, of kOne
};

// Trilinear mean of the cell at (x, y, z) of the patch; nothing unless every corner that counts is observed.
std::optional<Sample> interpolate(const Patch& patch, const std::array<int, 3>& cell,
                                  const std::array<int, 3>& fraction) {
  Sample out;
  int least = kTsdfOne, most = -kTsdfOne;
  for (int c = 0; c < 8; ++c) {
    const int dx = c & 1, dy = (c >> 1) & 1, dz = c >> 2;
    const std::int64_t share = static_cast<std::int64_t>(dx != 0 ? fraction[0] : kFraction - fraction[0]) *
                               (dy != 0 ? fraction[1] : kFraction - fraction[1]) *
                               (dz != 0 ? fraction[2] : kFraction - fraction[2]);
    if (share == 0) continue;
    const SubmapVoxel& voxel = patch.voxels[Patch::index(cell[0] + dx, cell[1] + dy, cell[2] + dz)];
    if (voxel.weight == 0) return std::nullopt;
    least = std::min<int>(least, voxel.tsdf);
    most = std::max<int>(most, voxel.tsdf);
    out.tsdf += share * voxel.tsdf;
    out.weight += share * voxel.weight;
    if (voxel.rgb == Rgb{}) continue;
    out.color += share;
    for (std::size_t i = 0; i < 3; ++i) out.rgb[i] += share * voxel.rgb[i];
  }
  if (most - least > kLargestSpread) return std::nullopt;
  return out;
}

class Resampler {
 public:
  Resampler(const Grid& grid, std::int64_t truncation_um, Fusing how, VoxelMap& map)
      : grid_(grid),
        truncation_um_(truncation_um),
        map_truncation_um_(map.config().truncation_um()),
        how_(how),
        map_(map) {}
  bool exact() const { return exact_; }

  void fuse(const Patch& patch) {
    if (patch.low[0] > patch.high[0]) return;
    patch_ = &patch;
    const std::array<std::int32_t, 3> key{patch.key.x, patch.key.y, patch.key.z};
    for (std::size_t i = 0; i < 3; ++i) {
      from_[i] = std::int64_t{kBlockSide} * key[i] + patch.low[i];
      to_[i] = std::int64_t{kBlockSide} * key[i] + patch.high[i] + 1;
    }
    find_reach();
    for (std::int64_t z = low_[2]; z <= high_[2]; ++z)
      for (std::int64_t y = low_[1]; y <= high_[1]; ++y) fuse_row(y, z);
  }

 private:
  // The box of global voxels that holds the observed part of the source block, and room for its blocks' addresses.
  void find_reach() {
    std::array<double, 3> least{1e300, 1e300, 1e300}, most{-1e300, -1e300, -1e300};
    for (int c = 0; c < 8; ++c) {
      std::array<double, 3> p{};
      for (std::size_t i = 0; i < 3; ++i)
        p[i] = (static_cast<double>(((c >> i) & 1) != 0 ? to_[i] : from_[i]) + 0.5) * grid_.source_m;
      for (std::size_t i = 0; i < 3; ++i) {
        const auto& R = grid_.T_map_anchor.R;
        const int row = static_cast<int>(i);
        const double g =
            (R(row, 0) * p[0] + R(row, 1) * p[1] + R(row, 2) * p[2] + grid_.T_map_anchor.t[row]) / grid_.global_m - 0.5;
        least[i] = std::min(least[i], g);
        most[i] = std::max(most[i], g);
      }
    }
    std::size_t blocks = 1;
    for (std::size_t i = 0; i < 3; ++i) {
      low_[i] = floor_int<std::int64_t>(least[i] - 0.1);
      high_[i] = floor_int<std::int64_t>(most[i] + 1.1);
      first_block_[i] = low_[i] >> 3;
      blocks_[i] = static_cast<std::size_t>((high_[i] >> 3) - first_block_[i] + 1);
      blocks *= blocks_[i];
    }
    cache_.assign(blocks, {});
  }

  // The part of the row where the source block is, a little too long; each voxel is tested exactly later.
  void clip_row(std::int64_t y, std::int64_t z, std::int64_t& first, std::int64_t& last) const {
    double t0 = static_cast<double>(first), t1 = static_cast<double>(last);
    for (std::size_t i = 0; i < 3; ++i) {
      const double start = grid_.at(i, 0, static_cast<double>(y), static_cast<double>(z)), slope = grid_.A[i][0];
      const double a = static_cast<double>(from_[i]) - 0.01 - start, b = static_cast<double>(to_[i]) + 0.01 - start;
      if (slope > 1e-6 || slope < -1e-6) {
        t0 = std::max(t0, (slope > 0 ? a : b) / slope - 0.01);
        t1 = std::min(t1, (slope > 0 ? b : a) / slope + 0.01);
      } else if (a > 0.1 || b < -0.1) {
        t1 = t0 - 1;
      }
    }
    if (t1 < t0) {
      last = first - 1;
      return;
    }
    first = std::max(first, floor_int<std::int64_t>(t0));
    last = std::min(last, floor_int<std::int64_t>(t1) + 1);
  }

  void fuse_row(std::int64_t y, std::int64_t z) {
    std::int64_t first = low_[0], last = high_[0];
    clip_row(y, z, first, last);
    for (std::int64_t x = first; x <= last; ++x) {
      std::array<int, 3> cell{}, fraction{};
      bool within = true;
      for (std::size_t i = 0; i < 3; ++i) {
        const double s = grid_.at(i, static_cast<double>(x), static_cast<double>(y), static_cast<double>(z));
        const std::int64_t fixed = floor_int<std::int64_t>(s * kFraction + 0.5);
        const std::int64_t base = fixed >> 8;
        within = within && base >= from_[i] && base < to_[i];
        cell[i] = static_cast<int>(base & (kBlockSide - 1));
        fraction[i] = static_cast<int>(fixed & (kFraction - 1));
      }
      if (!within) continue;
      if (const auto sample = interpolate(*patch_, cell, fraction)) add(*sample, x, y, z);
    }
  }

  void add(const Sample& sample, std::int64_t x, std::int64_t y, std::int64_t z) {
    const std::int64_t tsdf = rounded_ratio(rounded_ratio(sample.tsdf * truncation_um_, map_truncation_um_), kOne);
    if (tsdf < -kTsdfOne || tsdf > kTsdfOne) return;
    Voxel* block = block_at(x >> 3, y >> 3, z >> 3);
    if (block == nullptr) {
      exact_ = false;
      return;
    }
    const auto m = std::int64_t{kBlockSide - 1};
    Voxel& voxel = block[((z & m) * kBlockSide + (y & m)) * kBlockSide + (x & m)];
    const int weight = static_cast<int>(std::max<std::int64_t>(1, rounded_ratio(sample.weight, kOne)));
    const auto mean = [&](std::size_t i) { return static_cast<int>(rounded_ratio(sample.rgb[i], sample.color)); };
    if (how_ == Fusing::take_back) {
      voxel.take_tsdf(static_cast<int>(tsdf), weight);
      if (sample.color != 0) voxel.take_color(mean(0), mean(1), mean(2));
      return;
    }
    exact_ = exact_ && !voxel.would_saturate(weight) && !(sample.color != 0 && voxel.color_would_saturate());
    voxel.add_tsdf(static_cast<int>(tsdf), weight);
    if (sample.color != 0) voxel.add_color(mean(0), mean(1), mean(2));
  }

  // The global block; asked for only when it gets a voxel, and once for each source block even when it is refused.
  Voxel* block_at(std::int64_t x, std::int64_t y, std::int64_t z) {
    const auto at = [&](std::int64_t v, std::size_t i) { return static_cast<std::size_t>(v - first_block_[i]); };
    Slot& slot = cache_[(at(z, 2) * blocks_[1] + at(y, 1)) * blocks_[0] + at(x, 0)];
    if (!slot.asked) {
      slot.asked = true;
      slot.block =
          map_.find_or_add({static_cast<std::int32_t>(x), static_cast<std::int32_t>(y), static_cast<std::int32_t>(z)});
    }
    return slot.block;
  }

  struct Slot {
    Voxel* block = nullptr;
    bool asked = false;
  };
  const Grid& grid_;
  std::int64_t truncation_um_, map_truncation_um_;
  const Fusing how_;
  VoxelMap& map_;
  bool exact_ = true;
  const Patch* patch_ = nullptr;
  std::array<std::int64_t, 3> from_{}, to_{};   // observed cells of the source block, [from, to)
  std::array<std::int64_t, 3> low_{}, high_{};  // global voxels in reach, both included
  std::array<std::int64_t, 3> first_block_{};
  std::array<std::size_t, 3> blocks_{};
  std::vector<Slot> cache_;
};

}  // namespace

bool fuse_submap(std::span<const AtlasBlock> blocks, const QuantizedPose& T_map_anchor, Fusing how, VoxelMap& map,
                 const std::vector<BlockKey>* only) {
  if (blocks.empty()) return true;
  const Grid grid(T_map_anchor, blocks.front().voxel_um, map.config().voxel_um());
  Resampler resampler(grid, blocks.front().truncation_um, how, map);
  Patch patch;
  for (const AtlasBlock& block : blocks) {
    if (only != nullptr && !std::ranges::binary_search(*only, block.block->key)) continue;
    patch.gather(blocks, *block.block);
    resampler.fuse(patch);
  }
  return resampler.exact();
}

}  // namespace onemap::mapping
