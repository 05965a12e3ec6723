#pragma once
#include <cstdint>
#include <vector>

#include "hal/base/record.hpp"

namespace onemap::mapping {

// What remains of a keyframe whose views are not needed any more: the body of a record that is to replace it.
struct KeyframeRemains {
  RecordId of;
  std::vector<std::uint8_t> body;
};

// Records that make room.
struct SpareRecords {
  std::vector<RecordId> needless;          // own voxel records that the map can do without: later ones are to name them
  std::vector<KeyframeRemains> keyframes;  // own ones, to be written in their places
  std::vector<RecordId> unread;            // anybody's that were named, and that nobody here reads again

  bool empty() const { return needless.empty() && keyframes.empty() && unread.empty(); }
};

}  // namespace onemap::mapping
