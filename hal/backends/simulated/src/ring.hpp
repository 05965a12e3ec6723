#pragma once
#include "scene.hpp"

namespace onemap::hal::simulated {

// A corridor that leads round a square block and into itself, 60 m along its middle and 2.4 m wide. Its doors and their
// signs look alike on purpose; what hangs and stands between them does not.
void ring(SceneBuilder& b);

// The robots start at equal distances and walk round it the same way, 0.6 m/s, eyes ahead and a little outward: a round
// takes 100 s.
CameraPose pose_in_ring(int robot, int robots, std::uint64_t seed, double time_s);

}  // namespace onemap::hal::simulated
