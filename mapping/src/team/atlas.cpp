#include "mapping/team/atlas.hpp"

#include <algorithm>
#include <optional>
#include <tuple>

namespace onemap::mapping {
namespace {

constexpr std::int64_t kLargestRatio = 4;  // of voxel sizes; beyond it resampling would skip or smear surfaces

auto kind_of(const AtlasBlock& b) { return std::tie(b.voxel_um, b.truncation_um); }
auto place_of(const AtlasBlock& b) { return std::tie(b.voxel_um, b.truncation_um, b.block->key); }

// No frames are fused here, and a small team's map leaves most of the budget to others.
VoxelMapConfig for_atlas(VoxelMapConfig config) {
  config.image_pixels = 0;
  config.resident = false;
  return config;
}

using Run = std::span<const AtlasBlock>;

// The blocks of one kind, sorted by key.
Run run_of(const std::vector<AtlasBlock>& blocks, std::int32_t voxel_um, std::int32_t truncation_um) {
  const auto kind = std::tie(voxel_um, truncation_um);
  return {std::ranges::lower_bound(blocks, kind, {}, kind_of), std::ranges::upper_bound(blocks, kind, {}, kind_of)};
}

// Where two versions of a submap differ: these blocks, and those below them, whose cells reach into them.
std::vector<BlockKey> differing(Run before, Run after) {
  std::vector<BlockKey> out;
  const auto differs = [&](const BlockKey& key) {
    for (int n = 0; n < 8; ++n) out.push_back({key.x - (n & 1), key.y - ((n >> 1) & 1), key.z - (n >> 2)});
  };
  auto b = before.begin();
  auto a = after.begin();
  while (b != before.end() || a != after.end()) {
    if (a == after.end() || (b != before.end() && b->block->key < a->block->key)) {
      differs((b++)->block->key);
    } else if (b == before.end() || a->block->key < b->block->key) {
      differs((a++)->block->key);
    } else {
      if (a->sequence != b->sequence) differs(a->block->key);
      ++a;
      ++b;
    }
  }
  std::ranges::sort(out);
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

std::vector<std::tuple<std::int32_t, std::int32_t>> kinds(const std::vector<AtlasBlock>& a,
                                                          const std::vector<AtlasBlock>& b) {
  std::vector<std::tuple<std::int32_t, std::int32_t>> out;
  for (const auto* blocks : {&a, &b})
    for (const AtlasBlock& block : *blocks)
      if (out.empty() || out.back() != kind_of(block)) out.emplace_back(kind_of(block));
  std::ranges::sort(out);
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

}  // namespace

std::vector<AtlasBlock> latest_blocks(std::span<const Atlas::Submap> submaps) {
  std::vector<AtlasBlock> out;
  for (const Atlas::Submap& submap : submaps)
    for (const SubmapBlock& block : submap.record->blocks)
      out.push_back({submap.record->voxel_um, submap.record->truncation_um, submap.sequence, &block});
  std::sort(out.begin(), out.end(), [](const AtlasBlock& a, const AtlasBlock& b) {
    const auto pa = place_of(a), pb = place_of(b);
    return pa != pb ? pa < pb : a.sequence > b.sequence;  // the latest first
  });
  const auto same_place = [](const AtlasBlock& a, const AtlasBlock& b) { return place_of(a) == place_of(b); };
  out.erase(std::unique(out.begin(), out.end(), same_place), out.end());
  return out;
}

void LatestSubmaps::add_older(std::uint32_t sequence, SubmapRecord record) {
  const auto seen_before = static_cast<std::ptrdiff_t>(seen_.size());
  auto at = seen_.begin();  // the record's blocks are sorted, as these are
  std::vector<Place> added;
  std::erase_if(record.blocks, [&](const SubmapBlock& block) {
    const Place place{record.voxel_um, record.truncation_um, block.key};
    at = std::lower_bound(at, seen_.end(), place);
    if (at != seen_.end() && *at == place) return true;
    added.push_back(place);
    return false;
  });
  if (record.blocks.empty()) return;
  seen_.insert(seen_.end(), added.begin(), added.end());
  std::inplace_merge(seen_.begin(), seen_.begin() + seen_before, seen_.end());
  record.blocks.shrink_to_fit();
  records_.push_back(std::move(record));
  submaps_.push_back({sequence, &records_.back()});
}

Atlas::Atlas(const AtlasConfig& config) : map_(for_atlas(config.map)) {}

void Atlas::clear() {
  map_.clear();
  counters_ = {};
  exact_ = true;
}

void Atlas::replace(const Placed& before, const Placed& after) {
  const std::vector<AtlasBlock> old = latest_blocks(before.submaps), now = latest_blocks(after.submaps);
  counters_.blocks += now.size() - old.size();
  const std::int64_t global_um = map_.config().voxel_um();
  for (const auto& [voxel_um, truncation_um] : kinds(old, now)) {
    const Run was = run_of(old, voxel_um, truncation_um), is = run_of(now, voxel_um, truncation_um);
    if (voxel_um > kLargestRatio * global_um || kLargestRatio * voxel_um < global_um) {
      counters_.blocks_left_out += is.size() - was.size();
      continue;
    }
    std::optional<std::vector<BlockKey>> only;
    if (before.T_map_anchor == after.T_map_anchor && !was.empty() && !is.empty()) only = differing(was, is);
    const std::vector<BlockKey>* where = only ? &*only : nullptr;
    exact_ = fuse_submap(was, before.T_map_anchor, Fusing::take_back, map_, where) && exact_;
    exact_ = fuse_submap(is, after.T_map_anchor, Fusing::add, map_, where) && exact_;
  }
}

}  // namespace onemap::mapping
