#pragma once
#include <vector>

#include "hal/base/result.hpp"
#include "mapping/team/free_space.hpp"

namespace onemap::mapping {

struct FloorPlanConfig {
  // Heights above the floor between which something is in the way of a robot, metres.
  double low_m = 0.10, high_m = 1.80;
};

// Where a robot can drive, seen from above: squares of the size of the free space's cells.
struct FloorPlan {
  int width = 0, height = 0;  // at least 1
  double cell_m = 0;
  double origin_x_m = 0, origin_y_m = 0;  // of the lowest corner, in the level frame
  std::vector<Space> cells;               // row by row from the lowest y; x rises along a row

  Space at(int x, int y) const {
    return cells[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
  }
};

// The plan of a space that was carved in a level frame (see level_frame: z up, floor at z = 0), as large as what is
// known of it. A square is occupied when something stands in its column between low_m and high_m above the floor; free
// when nothing does and its floor was seen or half of the column was seen through; else unknown. The error says that
// nothing is known, or that the plan would be too large to be one.
Result<FloorPlan> floor_plan(const FreeSpace& space, const FloorPlanConfig& config);

}  // namespace onemap::mapping
