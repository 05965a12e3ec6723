#pragma once
#include <cmath>

#include "render/scene.hpp"

namespace onemap::test {

using mapping::Vector3f;

// Adds a rectangle origin + s * u + t * v (s, t in 0..1), cut into tiles of two colours; seen from the side where u x v
// points to.
inline void add_tiles(mapping::TriangleMesh& mesh, const Vector3f& origin, const Vector3f& u, const Vector3f& v,
                      int tiles, mapping::Rgb even, mapping::Rgb odd) {
  const Vector3f normal = u.cross(v).normalized();
  for (int j = 0; j < tiles; ++j) {
    for (int i = 0; i < tiles; ++i) {
      const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
      for (int k = 0; k < 4; ++k) {
        const auto s = static_cast<float>(i + (k == 1 || k == 2 ? 1 : 0)) / static_cast<float>(tiles);
        const auto t = static_cast<float>(j + (k >= 2 ? 1 : 0)) / static_cast<float>(tiles);
        mesh.vertices.emplace_back(origin + s * u + t * v);
        mesh.normals.push_back(normal);
        mesh.colors.push_back((i + j) % 2 == 0 ? even : odd);
      }
      mesh.triangles.push_back({first, first + 1, first + 2});
      mesh.triangles.push_back({first, first + 2, first + 3});
    }
  }
}

// An axis-aligned box; its faces look outwards (inside = false) or inwards. Colours: floor/bottom, top, four sides.
inline void add_box(mapping::TriangleMesh& mesh, const Vector3f& low, const Vector3f& high, bool inside, int tiles,
                    const std::array<mapping::Rgb, 6>& colors) {
  const Vector3f d = high - low, x(d.x(), 0, 0), y(0, d.y(), 0), z(0, 0, d.z());
  const auto face = [&](const Vector3f& origin, const Vector3f& u, const Vector3f& v, mapping::Rgb c) {
    const mapping::Rgb dark{static_cast<std::uint8_t>(c[0] * 4 / 5), static_cast<std::uint8_t>(c[1] * 4 / 5),
                            static_cast<std::uint8_t>(c[2] * 4 / 5)};
    if (inside)
      add_tiles(mesh, origin, v, u, tiles, c, dark);
    else
      add_tiles(mesh, origin, u, v, tiles, c, dark);
  };
  face(low + y, z, x, colors[0]);  // below (y down): outwards is +y
  face(low, x, z, colors[1]);      // above: -y
  face(low, z, y, colors[2]);      // -x
  face(low + x, y, z, colors[3]);  // +x
  face(low, y, x, colors[4]);      // -z
  face(low + z, x, y, colors[5]);  // +z
}

// A pose at a place, looking along (sin yaw, 0, cos yaw), y down.
inline mapping::Pose level_pose(double x, double y, double z, double yaw_rad) {
  const double c = std::cos(yaw_rad), s = std::sin(yaw_rad);
  mapping::Pose pose;
  pose.R << c, 0, s, 0, 1, 0, -s, 0, c;
  pose.t = {x, y, z};
  return pose;
}

// A furnished room of 4 x 2.5 x 5 metres around the origin at eye height, and three robots that walked in it.
inline render::Scene room_scene() {
  render::Scene scene;
  scene.title = "room";
  auto& mesh = scene.mesh;
  add_box(mesh, {-2, -1, -1}, {2, 1.5f, 4}, true, 8,
          {{{150, 120, 90}, {235, 235, 230}, {200, 205, 190}, {190, 200, 210}, {205, 195, 190}, {210, 200, 180}}});
  const auto plain = [](mapping::Rgb c) { return std::array<mapping::Rgb, 6>{c, c, c, c, c, c}; };
  add_box(mesh, {-0.7f, 0.7f, 1.8f}, {0.8f, 0.8f, 2.8f}, false, 4, plain({120, 70, 40}));  // table top
  add_box(mesh, {-0.6f, 0.8f, 1.9f}, {-0.5f, 1.5f, 2.0f}, false, 1, plain({90, 50, 30}));  // its legs
  add_box(mesh, {0.6f, 0.8f, 2.6f}, {0.7f, 1.5f, 2.7f}, false, 1, plain({90, 50, 30}));
  add_box(mesh, {-0.2f, 0.3f, 2.2f}, {0.3f, 0.7f, 2.5f}, false, 1, plain({40, 90, 170}));  // a blue crate on it
  add_box(mesh, {1.2f, 0.2f, 3.0f}, {1.9f, 1.5f, 3.9f}, false, 2, plain({170, 150, 60}));  // a cupboard
  for (std::size_t robot = 0; robot < 3; ++robot) {
    render::RobotPath path{"robot" + std::to_string(robot + 1), render::robot_color(robot), {}, {}};
    for (int i = 0; i <= 60; ++i) {
      const double s = i / 60.0, side = static_cast<double>(robot) - 1.0;
      path.poses.push_back(
          level_pose(side * 1.1 + 0.3 * std::sin(5 * s), 0.15 * side, -0.7 + 1.8 * s, -0.4 * side + 0.3 * s));
      if (i % 15 == 0) path.keyframe_poses.push_back(path.poses.back());
    }
    scene.robots.push_back(path);
  }
  return scene;
}

}  // namespace onemap::test
