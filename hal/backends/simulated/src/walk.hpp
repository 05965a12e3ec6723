#pragma once
#include <array>
#include <cstdint>

#include "arithmetic.hpp"
#include "scene.hpp"

namespace onemap::hal::simulated {

// A hand's unrest: a slow and a quick sine with phases of their own.
struct Sway {
  double slow, slow_hz, quick, quick_hz, phase_a, phase_b;
  double at(double t) const {
    return slow * sin_turns(slow_hz * t + phase_a) + quick * sin_turns(quick_hz * t + phase_b);
  }
};
// Of these sizes, at about these frequencies.
Sway sway(Random& random, double slow, double slow_hz, double quick, double quick_hz);

// A camera that looks so many turns from east, from level and about its own axis.
CameraPose looking(Vec3 position, double yaw, double pitch, double roll);

// Where robot number `robot` (from 1) of a team looks from, seconds after its start. Smooth: sums of sines of time.
CameraPose pose_on_walk(const Walk& walk, int robot, int robots, std::uint64_t seed, double time_s);

// Unit quaternion x y z w, w >= 0, of the camera's rotation to the world.
std::array<double, 4> quaternion_xyzw(const CameraPose& pose);

}  // namespace onemap::hal::simulated
