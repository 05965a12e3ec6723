#pragma once
#include <array>
#include <cstdint>

#include "arithmetic.hpp"
#include "scene.hpp"

namespace onemap::hal::simulated {

// Where robot number `robot` (from 1) of a team looks from, seconds after its start. Smooth: sums of sines of time.
CameraPose pose_on_walk(const Walk& walk, int robot, int robots, std::uint64_t seed, double time_s);

// Unit quaternion x y z w, w >= 0, of the camera's rotation to the world.
std::array<double, 4> quaternion_xyzw(const CameraPose& pose);

}  // namespace onemap::hal::simulated
