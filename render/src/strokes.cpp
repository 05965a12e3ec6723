#include "strokes.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace onemap::render {
namespace {

constexpr std::uint8_t kFaceOpacity = 40;

glm::vec3 to_glm(const mapping::Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

Rgba with_alpha(const Color& c, std::uint8_t alpha) { return {c[0], c[1], c[2], alpha}; }

// Metres that one pixel spans at a point.
float metres_per_pixel(const glm::vec3& p, const Camera& camera, const Style& style) {
  const float depth = std::max(glm::dot(p - camera.eye, glm::normalize(camera.target - camera.eye)), camera.near_m);
  return 2 * depth * std::tan(0.5f * camera.fov_y_rad) / static_cast<float>(style.height_px);
}

// Poses less than a pixel apart make one: their strokes would only show the tracker's noise as bristles.
void add_trajectory(const RobotPath& robot, const Camera& camera, const Style& style, std::vector<Stroke>& out) {
  const auto& poses = robot.poses.empty() ? robot.keyframe_poses : robot.poses;
  if (poses.empty()) return;
  glm::vec3 last = to_glm(poses.front().t);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const glm::vec3 p = to_glm(poses[i].t);
    const bool near = glm::distance(p, last) < metres_per_pixel(p, camera, style);
    if (near && i + 1 != poses.size()) continue;
    out.push_back({last, p, with_alpha(robot.color, 255), style.path_width_px});
    last = p;
  }
}

void add_marker(const mapping::Pose& pose, const Color& color, float depth_m, float width_px, PathShapes& out) {
  const auto corner = pyramid(pose, depth_m);
  for (std::size_t i = 1; i < 5; ++i) {
    const glm::vec3 &a = corner[i], &b = corner[i % 4 + 1];
    out.strokes.push_back({corner[0], a, with_alpha(color, 255), width_px});
    out.strokes.push_back({a, b, with_alpha(color, 255), width_px});
    for (const glm::vec3& p : {corner[0], a, b}) out.faces.push_back({p, with_alpha(color, kFaceOpacity)});
  }
}

}  // namespace

std::array<glm::vec3, 5> pyramid(const mapping::Pose& pose, float depth_m) {
  const double d = depth_m, w = 0.62 * d, h = 0.46 * d;  // a depth camera's field of view, about 64 x 50 degrees
  const auto at = [&](double x, double y, double z) { return to_glm(pose * mapping::Vector3d(x, y, z)); };
  return {at(0, 0, 0), at(-w, -h, d), at(w, -h, d), at(w, h, d), at(-w, h, d)};
}

PathShapes path_shapes(const Scene& scene, const Camera& camera, const Style& style) {
  const float pixel_m = metres_per_pixel(camera.target, camera, style);
  const float automatic = std::clamp(0.03f * pixel_m * static_cast<float>(style.height_px), 0.01f, 0.5f);
  const float depth_m = style.marker_size_m > 0 ? style.marker_size_m : automatic;
  PathShapes shapes;
  for (const RobotPath& robot : scene.robots) {
    add_trajectory(robot, camera, style, shapes.strokes);
    for (const auto& pose : robot.keyframe_poses) add_marker(pose, robot.color, depth_m, style.marker_width_px, shapes);
  }
  return shapes;
}

}  // namespace onemap::render
