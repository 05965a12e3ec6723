// Moves one submap's voxels into the global map. Positions are doubles from + - * / in an order that is written out; at
// once they become integers in 1/256 of a source voxel, and everything after that is integer arithmetic.
#include <algorithm>
#include <array>
#include <optional>

#include "local/match_internal.hpp"
#include "mapping/team/atlas.hpp"
#include "team/cells.hpp"
#include "team/patch.hpp"
#include "team/source_grid.hpp"

namespace onemap::mapping {
namespace {

using cells::kOne;
using cells::Sample;

std::int64_t rounded_ratio(std::int64_t a, std::int64_t b) { return a >= 0 ? (a + b / 2) / b : -((-a + b / 2) / b); }

// Of a place on a face of its cell: nothing unless every corner that has a share is observed.
std::optional<Sample> blend_on_face(const Patch& patch, const cells::Place& place) {
  Sample out{};
  int least = kTsdfOne, most = -kTsdfOne;
  for (unsigned c = 0; c < 8; ++c) {
    std::uint32_t share = 1;
    std::array<int, 3> at{};
    for (std::size_t i = 0; i < 3; ++i) {
      const int upper = (c >> i) & 1;
      share *= upper != 0 ? place.fraction(i) : cells::kFraction - place.fraction(i);
      at[i] = place.at(i) + upper;
    }
    if (share == 0) continue;
    if (!patch.observed(at[0], at[1], at[2])) return std::nullopt;
    const int tsdf = patch.tsdf(at[0], at[1], at[2]);
    least = std::min(least, tsdf);
    most = std::max(most, tsdf);
    const Patch::Voxel voxel = patch.voxels()[Patch::index(at[0], at[1], at[2])];
    for (std::size_t k = 0; k < Patch::kLanes; ++k) out.sums[k] += share * Patch::lane(voxel, k);
  }
  if (most - least > Patch::kLargestSpread) return std::nullopt;
  for (std::size_t k = 0; k < Patch::kLanes; ++k) out.means[k] = (out.sums[k] + cells::kHalf) / kOne;
  out.tsdf = cells::distance(out.sums);
  return out;
}

class Resampler {
 public:
  Resampler(const SourceGrid& grid, std::int64_t truncation_um, Fusing how, VoxelMap& map, bool simd)
      : grid_(grid),
        truncation_um_(truncation_um),
        map_truncation_um_(map.config().truncation_um()),
        how_(how),
        map_(map),
        find_(simd ? cells::find_simd : cells::find_plain),
        blend_(simd ? cells::blend_simd : cells::blend_plain) {}
  bool exact() const { return exact_; }

  void fuse(const Patch& patch) {
    if (patch.empty()) return;
    box_.reach(grid_, patch);
    if (box_.empty()) return;
    slots_.assign(static_cast<std::size_t>(box_.blocks[0] * box_.blocks[1] * box_.blocks[2]), nullptr);
    const auto most = static_cast<std::size_t>(box_.size(0) * box_.size(1) + cells::kStride);
    if (places_.size() < most) {
      places_.resize(most);
      samples_.resize(most);
    }
    cells::Rows rows = rows_of(grid_, patch, box_);
    for (int z = 0; z < box_.size(2); ++z) {
      set_z(box_, static_cast<std::size_t>(z), rows);
      cells::Place* end = places_.data();
      find_(rows, end);
      add_all(patch, static_cast<std::size_t>(end - places_.data()));
    }
  }

 private:
  void add_all(const Patch& patch, std::size_t count) {
    blend_(patch.voxels(), places_.data(), count, samples_.data());
    for (std::size_t i = 0; i < count; ++i) {
      const cells::Place& place = places_[i];
      prefetch(places_[std::min(i + kAhead, count - 1)]);
      if (place.whole != 0)
        add(samples_[i], place.number);
      else if (const auto sample = blend_on_face(patch, place))
        add(*sample, place.number);
    }
  }

  // The map is larger than the caches.
  void prefetch(const cells::Place& place) const {
    const Voxel* block = slots_[place.number / kBlockVoxels];
    if (block != nullptr && block != &refused_) __builtin_prefetch(block + place.number % kBlockVoxels, 1);
  }

  // In units of the map's truncation.
  std::int64_t distance(const Sample& sample) const {
    if (truncation_um_ == map_truncation_um_) return rounded_ratio(sample.tsdf, kOne);
    return rounded_ratio(rounded_ratio(sample.tsdf * truncation_um_, map_truncation_um_), kOne);
  }

  void add(const Sample& sample, std::uint32_t number) {
    const auto tsdf = static_cast<int>(distance(sample));
    if (tsdf < -kTsdfOne || tsdf > kTsdfOne) return;
    Voxel* block = block_at(number / kBlockVoxels);
    if (block == &refused_) {
      exact_ = false;
      return;
    }
    Voxel& voxel = block[number % kBlockVoxels];
    const int weight = std::max(1, static_cast<int>(sample.means[Patch::kWeight]));
    const bool colored = sample.sums[Patch::kColored] != 0;
    const std::array<int, 3> rgb = color(sample);
    if (how_ == Fusing::take_back) {
      voxel.take_tsdf(tsdf, weight);
      if (colored) voxel.take_color(rgb[0], rgb[1], rgb[2]);
      return;
    }
    exact_ = exact_ && !voxel.would_saturate(weight) && !(colored && voxel.color_would_saturate());
    voxel.add_tsdf(tsdf, weight);
    if (colored) voxel.add_color(rgb[0], rgb[1], rgb[2]);
  }
  // The mean over those corners that have one.
  static std::array<int, 3> color(const Sample& sample) {
    const std::uint32_t share = sample.sums[Patch::kColored];
    std::array<int, 3> out{};
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t lane = Patch::kRed + i;
      out[i] =
          static_cast<int>(share == kOne || share == 0 ? sample.means[lane] : (sample.sums[lane] + share / 2) / share);
    }
    return out;
  }

  // The global block; asked for only when it gets a voxel, and once for each source block even when it is refused.
  Voxel* block_at(std::uint32_t number) {
    Voxel*& slot = slots_[number];
    if (slot == nullptr) {
      slot = map_.find_or_add(key_of(number));
      if (slot == nullptr) slot = &refused_;
    }
    return slot;
  }
  BlockKey key_of(std::uint32_t number) const {
    const auto& count = box_.blocks;
    const auto at = [&](std::int64_t n, std::size_t i) { return static_cast<std::int32_t>(n + box_.first_block[i]); };
    return {at(number % count[0], 0), at(number / count[0] % count[1], 1), at(number / (count[0] * count[1]), 2)};
  }

  static constexpr std::size_t kAhead = 12;

  const SourceGrid& grid_;
  const std::int64_t truncation_um_, map_truncation_um_;
  const Fusing how_;
  VoxelMap& map_;
  bool exact_ = true;
  ReachBox box_;
  void (*const find_)(const cells::Rows&, cells::Place*&);
  void (*const blend_)(const Patch::Voxel*, const cells::Place*, std::size_t, Sample*);
  std::vector<Voxel*> slots_;  // of the box; nullptr: not asked for
  Voxel refused_;
  std::vector<cells::Place> places_;
  std::vector<Sample> samples_;
};

}  // namespace

bool fuse_submap(std::span<const AtlasBlock> blocks, const QuantizedPose& T_map_anchor, Fusing how, VoxelMap& map,
                 const std::vector<BlockKey>* only, bool simd) {
  if (blocks.empty()) return true;
  simd = simd && match::simd_available();
  const SourceGrid grid(T_map_anchor, blocks.front().voxel_um, map.config().voxel_um());
  Resampler resampler(grid, blocks.front().truncation_um, how, map, simd);
  Patch patch(simd);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (only != nullptr && !std::ranges::binary_search(*only, blocks[i].block->key)) continue;
    patch.gather(blocks, i);
    resampler.fuse(patch);
  }
  return resampler.exact();
}

}  // namespace onemap::mapping
