#pragma once
#include <cstddef>
#include <vector>

#include "render/scene.hpp"

namespace onemap::render {

// A robot's camera at every `every`-th place of its way, with its gaze: a model's trajectories are places only, so the
// gaze is interpolated between the keyframes, which are looked up in their order along the way. No keyframes: no poses.
std::vector<mapping::Pose> followed(const RobotPath& robot, std::size_t every);

}  // namespace onemap::render
