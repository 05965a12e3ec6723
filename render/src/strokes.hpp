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

// What stands for the robots in a picture, from the lowest layer to the highest: camera poses as pyramids whose tip is
// the camera and whose base is the picture that it takes (faces, then edges), a light seam of the trajectories, the
// trajectories with a ring where they start and a dot where they end.
struct PathShapes {
  std::vector<FaceVertex> faces;  // three a triangle
  std::vector<Stroke> edges, seams, paths;
};

PathShapes path_shapes(const Scene& scene, const Camera& camera, const Style& style);

}  // namespace onemap::render
