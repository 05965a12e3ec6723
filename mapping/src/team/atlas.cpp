#include "mapping/team/atlas.hpp"

#include <algorithm>
#include <tuple>

namespace onemap::mapping {
namespace {

constexpr std::int64_t kLargestRatio = 4;  // of voxel sizes; beyond it resampling would skip or smear surfaces

auto place_of(const AtlasBlock& b) { return std::tie(b.anchor, b.voxel_um, b.truncation_um, b.block->key); }

bool same_source(const AtlasBlock& a, const AtlasBlock& b) {
  return a.anchor == b.anchor && a.voxel_um == b.voxel_um && a.truncation_um == b.truncation_um;
}

// No frames are fused here, and a small team's map leaves most of the budget to others.
VoxelMapConfig for_atlas(VoxelMapConfig config) {
  config.image_pixels = 0;
  config.resident = false;
  return config;
}

}  // namespace

std::vector<AtlasBlock> latest_blocks(std::span<const Atlas::Submap> submaps) {
  std::vector<AtlasBlock> out;
  for (const Atlas::Submap& submap : submaps)
    for (const SubmapBlock& block : submap.record->blocks)
      out.push_back({submap.record->anchor_keyframe, submap.record->voxel_um, submap.record->truncation_um,
                     submap.sequence, &block});
  std::sort(out.begin(), out.end(), [](const AtlasBlock& a, const AtlasBlock& b) {
    const auto pa = place_of(a), pb = place_of(b);
    return pa != pb ? pa < pb : a.sequence > b.sequence;  // the latest first
  });
  const auto same_place = [](const AtlasBlock& a, const AtlasBlock& b) { return place_of(a) == place_of(b); };
  out.erase(std::unique(out.begin(), out.end(), same_place), out.end());
  return out;
}

void LatestSubmaps::add_older(std::uint32_t sequence, SubmapRecord record) {
  std::erase_if(record.blocks, [&](const SubmapBlock& block) {
    return !seen_.insert({record.anchor_keyframe, record.voxel_um, record.truncation_um, block.key}).second;
  });
  if (record.blocks.empty()) return;
  record.blocks.shrink_to_fit();
  records_.push_back(std::move(record));
  submaps_.push_back({sequence, &records_.back()});
}

Atlas::Atlas(const AtlasConfig& config) : map_(for_atlas(config.map)) {}

void Atlas::clear() {
  map_.clear();
  counters_ = {};
}

void Atlas::add(std::span<const PlacedAnchor> anchors, std::span<const Submap> submaps) {
  const std::vector<AtlasBlock> blocks = latest_blocks(submaps);
  counters_.blocks += blocks.size();
  if (!blocks.empty()) ++counters_.robots;
  const std::int64_t global_um = map_.config().voxel_um();
  for (auto first = blocks.begin(); first != blocks.end();) {
    const auto last =
        std::find_if_not(first, blocks.end(), [&](const AtlasBlock& b) { return same_source(b, *first); });
    const auto count = static_cast<std::uint64_t>(last - first);
    const auto at = std::ranges::lower_bound(anchors, first->anchor, {}, &PlacedAnchor::keyframe);
    if (at == anchors.end() || at->keyframe != first->anchor)
      counters_.blocks_unplaced += count;
    else if (first->voxel_um > kLargestRatio * global_um || kLargestRatio * first->voxel_um < global_um)
      counters_.blocks_left_out += count;
    else
      fuse_submap({first, last}, at->T_map_anchor, map_);
    first = last;
  }
}

}  // namespace onemap::mapping
