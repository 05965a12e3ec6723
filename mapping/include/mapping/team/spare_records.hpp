#pragma once
#include <vector>

#include "hal/base/record.hpp"

namespace onemap::mapping {

// Voxel records that make room.
struct SpareRecords {
  std::vector<RecordId> needless;  // own ones that the map can do without: those that follow are to name them
  std::vector<RecordId> unread;    // anybody's that were named, and that nobody here reads again
};

}  // namespace onemap::mapping
