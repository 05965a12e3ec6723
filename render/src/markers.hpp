#pragma once
#include <array>
#include <cstddef>
#include <glm/vec3.hpp>
#include <vector>

#include "render/scene.hpp"

namespace onemap::render {

// Which keyframes stand in a picture as pyramids: at most fifteen a robot, spread over its way, and how deep a pyramid
// is, by the distance between them.
struct Markers {
  std::vector<std::vector<std::size_t>> keyframes;  // of each robot of the scene
  float depth_m = 0.1f;
};
Markers choose_markers(const Scene& scene);

// The five corners of a camera pyramid of the given depth: the tip, then the base in a circle.
std::array<glm::vec3, 5> pyramid(const mapping::Pose& pose, float depth_m);

}  // namespace onemap::render
