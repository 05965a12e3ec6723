#include "mapping/team/atlas.hpp"

#include <xxhash.h>

#include <algorithm>
#include <tuple>

#include "hal/base/bytes.hpp"

namespace onemap::mapping {
namespace {

constexpr std::int64_t kLargestRatio = 4;  // of voxel sizes; beyond it resampling would skip or smear surfaces

auto place_of(const AtlasBlock& b) { return std::tie(b.robot, b.voxel_um, b.truncation_um, b.block->key); }

bool same_source(const AtlasBlock& a, const AtlasBlock& b) {
  return a.robot == b.robot && a.voxel_um == b.voxel_um && a.truncation_um == b.truncation_um;
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
      out.push_back({submap.robot, submap.record->voxel_um, submap.record->truncation_um, submap.sequence, &block});
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
    return !seen_.insert({record.voxel_um, record.truncation_um, block.key}).second;
  });
  if (record.blocks.empty()) return;
  record.blocks.shrink_to_fit();
  records_.push_back(std::move(record));
  submaps_.push_back({robot_, sequence, &records_.back()});
}

struct Atlas::Impl {
  explicit Impl(const AtlasConfig& config) : map(for_atlas(config.map)) {}
  VoxelMap map;
  SolutionRecord solution;
  AtlasCounters counters;
};

Atlas::Atlas(const AtlasConfig& config) : impl_(std::make_shared<Impl>(config)) {}

void Atlas::begin(const SolutionRecord& solution) {
  impl_->solution = solution;
  impl_->counters = {};
  impl_->map.clear();
}

void Atlas::add(const RobotId& robot, std::span<const Submap> submaps) {
  const auto& robots = impl_->solution.robots;
  const auto at = std::find_if(robots.begin(), robots.end(), [&](const SolvedRobot& s) { return s.robot == robot; });
  if (at == robots.end()) return;
  const std::vector<AtlasBlock> blocks = latest_blocks(submaps);
  AtlasCounters& counters = impl_->counters;
  counters.blocks += blocks.size();
  if (!blocks.empty()) ++counters.robots;
  const std::int64_t global_um = impl_->map.config().voxel_um();
  for (auto first = blocks.begin(); first != blocks.end();) {
    const auto last =
        std::find_if_not(first, blocks.end(), [&](const AtlasBlock& b) { return same_source(b, *first); });
    if (first->voxel_um > kLargestRatio * global_um || kLargestRatio * first->voxel_um < global_um)
      counters.blocks_left_out += static_cast<std::uint64_t>(last - first);
    else
      fuse_robot({first, last}, at->T_global_robot, impl_->map);
    first = last;
  }
}

const VoxelMap& Atlas::map() const { return impl_->map; }
const AtlasCounters& Atlas::counters() const { return impl_->counters; }

std::uint64_t Atlas::digest() const {
  std::vector<std::uint8_t> bytes = encode(impl_->solution);
  ByteWriter(bytes).put(impl_->map.digest());
  return XXH64(bytes.data(), bytes.size(), 0);
}

}  // namespace onemap::mapping
