#include "mapping/team/map_fusion.hpp"

#include <xxhash.h>

#include <algorithm>

#include "hal/base/bytes.hpp"
#include "mapping/team/placed_anchors.hpp"

namespace onemap::mapping {

MapParameters map_parameters(const AtlasConfig& config) {
  VoxelMapConfig map = config.map;
  map.image_pixels = 0;
  const std::size_t blocks = std::clamp<std::size_t>(VoxelMap::capacity_of(map), 1, 1u << 24);
  return {map.voxel_um(), map.truncation_um(), static_cast<std::uint32_t>(blocks)};
}

std::vector<ChainExtent> everything_here(const TeamLog& log, const SolutionRecord& solution) {
  std::vector<ChainExtent> out;
  out.reserve(solution.robots.size());
  for (const SolvedRobot& solved : solution.robots)
    if (const TeamMember* member = log.find(solved.chain); member != nullptr)
      out.push_back({solved.chain, static_cast<std::uint32_t>(member->keyframes.most_whole()),
                     static_cast<std::uint32_t>(member->submaps.most_whole())});
  return out;
}

bool holds(const TeamLog& log, const std::vector<ChainExtent>& extents) {
  return std::ranges::all_of(extents, [&](const ChainExtent& extent) {
    const TeamMember* member = log.find(extent.chain);
    return member != nullptr && member->keyframes.size() >= extent.keyframes &&
           member->keyframes.is_whole(extent.keyframes) && member->submaps.size() >= extent.submaps &&
           member->submaps.is_whole(extent.submaps);
  });
}

// Another voxel size is another map.
void MapFusion::prepare(const MapParameters& map) {
  if (atlas_ && map == parameters_) return;
  parameters_ = map;
  AtlasConfig config;
  config.map.voxel_m = static_cast<float>(map.voxel_um * 1e-6);
  config.map.truncation_m = static_cast<float>(map.truncation_um * 1e-6);
  config.map.budget_bytes = budget_bytes_;
  config.map.most_blocks = map.blocks;
  atlas_ = std::make_unique<Atlas>(config);
  fused_.clear();
}

void MapFusion::start_over() {
  atlas_->clear();
  fused_.clear();
  todo_.clear();
  unread_ = 0;
  for (auto at = wanted_.rbegin(); at != wanted_.rend(); ++at) todo_.push_back(at->first);
  from_nothing_ = true;
}

MapFusion::Versions MapFusion::wanted(const TeamLog& log) {
  Versions out;
  submaps_ = 0;
  blocks_unplaced_ = 0;
  for (const SolvedRobot& solved : target_->solution.robots) {
    const TeamMember* member = log.find(solved.chain);
    const auto extent = std::ranges::lower_bound(target_->extents, solved.chain, {}, &ChainExtent::chain);
    if (member == nullptr || extent == target_->extents.end() || extent->chain != solved.chain) continue;
    const auto anchors = placed_anchors(*member, solved, extent->keyframes);
    member->submaps.for_each_of(extent->submaps, [&](const SubmapPlace& submap) {
      ++submaps_;
      const auto at = std::ranges::lower_bound(anchors, submap.anchor, {}, &PlacedAnchor::keyframe);
      if (at == anchors.end() || at->keyframe != submap.anchor) {
        blocks_unplaced_ += submap.blocks;
        return;
      }
      Version& version = out[{solved.chain, submap.anchor}];
      version.T_map_anchor = at->T_map_anchor;
      version.records.push_back(submap.record);
    });
  }
  return out;
}

void MapFusion::aim(const TeamLog& log, MapTarget target) {
  prepare(target.solution.map);
  target_ = std::move(target);
  unread_ = 0;
  wanted_ = wanted(log);
  if (!atlas_->exact()) return start_over();
  from_nothing_ = fused_.empty();
  todo_.clear();
  for (const auto& [id, version] : fused_)
    if (!wanted_.contains(id)) todo_.push_back(id);
  for (const auto& [id, version] : wanted_)
    if (const auto was = fused_.find(id); was == fused_.end() || !was->second.same(version)) todo_.push_back(id);
  std::ranges::sort(todo_, std::greater<>());
  if (todo_.empty()) atlas_->settle();
}

// Of one submap, and twice that at once. It follows from the target, as what is refused must, for whoever can hold
// that.
std::size_t MapFusion::most_decoded() const {
  const std::size_t of_map = std::size_t{parameters_.blocks} * kBlockVoxels * sizeof(Voxel);
  return std::min(of_map, budget_bytes_) / sizeof(SubmapBlock) / 2;
}

// The newest first, so that what is too much is the oldest.
bool MapFusion::decode(const Version& version, Decoded& into, const std::function<bool()>& stop) const {
  for (auto held = version.records.rbegin(); held != version.records.rend(); ++held) {
    if (stop()) return false;
    const RecordPtr record = whole(*held, read_);
    if (record == nullptr) {
      into.unread.push_back({(*held)->id, "its body cannot be read where it is kept: the map has there what it had"});
      continue;
    }
    const auto header = decode_submap_header(record->body);
    if (header && !into.submaps.has_room(header->blocks)) {
      ++into.left_out;
      continue;
    }
    auto submap = decode_submap(record->body);
    if (submap)
      into.submaps.add_older(record->id.seq, std::move(*submap));
    else
      into.malformed.push_back({record->id, submap.error().text()});
  }
  return true;
}

void MapFusion::replace(const SubmapId& id, const Decoded& before, const Decoded& after) {
  const auto was = fused_.find(id);
  const auto is = wanted_.find(id);
  Atlas::Placed old, now;
  if (was != fused_.end()) old = {was->second.T_map_anchor, before.submaps.submaps()};
  if (is != wanted_.end()) now = {is->second.T_map_anchor, after.submaps.submaps()};
  atlas_->replace(old, now);
  ++fused_count_;
  if (is == wanted_.end()) {
    fused_.erase(was);
  } else {
    fused_[id] = is->second;
    fused_[id].left_out = after.left_out;
  }
}

bool MapFusion::step(const std::function<bool()>& stop) {
  const SubmapId id = todo_.back();
  Decoded before(most_decoded()), after(most_decoded());
  if (const auto was = fused_.find(id); was != fused_.end() && !decode(was->second, before, stop)) return false;
  if (const auto is = wanted_.find(id); is != wanted_.end() && !decode(is->second, after, stop)) return false;
  if (before.unread.empty() && after.unread.empty())
    replace(id, before, after);
  else
    ++unread_;
  for (const auto* bad : {&before.unread, &after.unread, &after.malformed})
    malformed_.insert(malformed_.end(), bad->begin(), bad->end());
  todo_.pop_back();
  if (!atlas_->exact() && !from_nothing_) start_over();
  if (todo_.empty()) atlas_->settle();
  return true;
}

std::size_t MapFusion::submaps_left_out() const {
  std::size_t out = 0;
  for (const auto& [id, version] : fused_) out += version.left_out;
  return out;
}

std::uint64_t MapFusion::digest() const {
  if (!done() || unread_ > 0) return 0;
  SolutionRecord named = target_->solution;
  named.reference.incarnation = 0;
  named.up = {};  // from floating point, and nothing of the map
  for (SolvedRobot& robot : named.robots) robot.chain.incarnation = 0;
  std::vector<std::uint8_t> bytes = encode(named);
  ByteWriter(bytes).put(atlas_->map().digest());
  return XXH64(bytes.data(), bytes.size(), 0);
}

}  // namespace onemap::mapping
