#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "mapping/geometry.hpp"

namespace onemap::mapping {

// A coloured point cloud; metres; normals are unit vectors or absent (empty).
struct ColoredCloud {
  std::vector<Vector3f> points;
  std::vector<Vector3f> normals;
  std::vector<Rgb> colors;
};

// A coloured triangle mesh; counter-clockwise from outside (the seen side); metres.
struct TriangleMesh {
  std::vector<Vector3f> vertices;
  std::vector<Vector3f> normals;
  std::vector<Rgb> colors;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

}  // namespace onemap::mapping
