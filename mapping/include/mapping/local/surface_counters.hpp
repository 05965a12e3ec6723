#pragma once
#include <cstdint>

namespace onemap::mapping {

struct SurfaceCounters {
  std::uint64_t integrated_frames = 0;
  std::uint64_t blocks_refused = 0, frames_short = 0;  // see VoxelMapCounters
  std::uint64_t submaps = 0, reopened = 0;             // begun anew, and opened again
  std::uint64_t submaps_dropped = 0;  // left long ago, and not known here any more; others have their records
  std::uint64_t frames_waiting = 0;   // not fused: the submaps that were left had not been handed out yet
};

}  // namespace onemap::mapping
