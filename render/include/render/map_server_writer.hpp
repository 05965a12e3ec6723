#pragma once
#include <string>

#include "hal/base/result.hpp"
#include "mapping/team/floor_plan.hpp"

namespace onemap::render {

// Writes a plan as ROS's map_server and nav2_map_server read it: STEM.pgm (P5: 254 free, 0 occupied, 205 unknown; the
// first row is the largest y) and STEM.yaml beside it, with the plan's lowest corner as origin. A comment in the yaml
// says where the map's own frame lies in the plan's: T_plan_map, for trajectories (tx ty tz qx qy qz qw). Each file
// whole or not at all, the yaml last.
Status write_map_server(const std::string& stem, const mapping::FloorPlan& plan, const mapping::Pose& T_plan_map);

}  // namespace onemap::render
