#include "mapping/team/local_atlas.hpp"

#include <algorithm>

namespace onemap::mapping {

Atlas local_atlas(const LocalMapper& mapper, const AtlasConfig& config) {
  std::vector<PlacedAnchor> anchors;
  std::deque<SubmapRecord> records;
  mapper.for_each_submap([&](const SubmapAnchor& anchor, const VoxelMap& voxels) {
    std::vector<BlockKey> keys;
    voxels.for_each([&](const BlockView& block) { keys.push_back(block.key); });
    SubmapRecord& record = records.emplace_back(make_submap(voxels, keys));
    record.anchor_keyframe = anchor.keyframe;
    anchors.push_back({anchor.keyframe, quantize(anchor.T_anchor_robot.inverse())});
  });
  std::ranges::sort(anchors, {}, &PlacedAnchor::keyframe);
  std::vector<Atlas::Submap> submaps;
  submaps.reserve(records.size());
  for (const SubmapRecord& record : records) submaps.push_back({0, &record});
  Atlas atlas(config);
  atlas.add(anchors, submaps);
  return atlas;
}

}  // namespace onemap::mapping
