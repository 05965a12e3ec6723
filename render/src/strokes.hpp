#pragma once
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "render/camera.hpp"
#include "render/renderer.hpp"
#include "render/scene.hpp"

namespace onemap::render {

using Rgba = std::array<std::uint8_t, 4>;

// A piece of a line as the stroke shader takes it.
struct Stroke {
  glm::vec3 from, to;
  Rgba color;
  float width_px;
};

// A corner of a translucent triangle.
struct FaceVertex {
  glm::vec3 position;
  Rgba color;
};

// What stands for the robots in a picture: trajectories as strokes, camera poses as pyramids whose tip is the camera
// and whose base is the picture that it takes.
struct PathShapes {
  std::vector<Stroke> strokes;
  std::vector<FaceVertex> faces;  // three a triangle
};

PathShapes path_shapes(const Scene& scene, const Camera& camera, const Style& style);

// The five corners of a camera pyramid of the given depth: the tip, then the base in a circle.
std::array<glm::vec3, 5> pyramid(const mapping::Pose& pose, float depth_m);

}  // namespace onemap::render
