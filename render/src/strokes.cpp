#include "strokes.hpp"

#include <algorithm>
#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <optional>

#include "markers.hpp"
#include "vectors.hpp"

namespace onemap::render {
namespace {

constexpr std::uint8_t kFaceOpacity = 36, kSeamOpacity = 170;
constexpr float kApart = 26.0f / 720;       // of the picture's height, between the tips of two pyramids
constexpr float kLeastDepth = 14.0f / 720;  // of a pyramid, so that it is seen
constexpr float kDot = 3.4f;                // diameter of an end's dot in widths of the path

Rgba with_alpha(const Color& c, std::uint8_t alpha) { return {c[0], c[1], c[2], alpha}; }
constexpr Color kLight{255, 255, 255};

void add_dot(const glm::vec3& at, const Color& color, float width_px, std::vector<Stroke>& out) {
  out.push_back({at, at, with_alpha(color, 255), width_px});
}

// Poses less than a pixel apart make one: their strokes would only show the tracker's noise as bristles.
void add_trajectory(const RobotPath& robot, const Camera& camera, const Style& style, PathShapes& out) {
  const auto& poses = robot.poses.empty() ? robot.keyframe_poses : robot.poses;
  if (poses.empty() || style.path_width_px <= 0) return;
  const float width_px = style.path_width_px, seam_px = std::min(0.66f * width_px, 0.35f * width_px + 0.8f);
  glm::vec3 last = to_glm(poses.front().t);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const glm::vec3 p = to_glm(poses[i].t);
    const bool near = glm::distance(p, last) < camera.metres_per_pixel(p, style.height_px);
    if (near && i + 1 != poses.size()) continue;
    out.seams.push_back({last, p, with_alpha(kLight, kSeamOpacity), width_px + 2 * seam_px});
    out.paths.push_back({last, p, with_alpha(robot.color, 255), width_px});
    last = p;
  }
  if (poses.size() < 2) return;
  const glm::vec3 start = to_glm(poses.front().t);
  add_dot(start, robot.color, kDot * width_px, out.paths);
  add_dot(start, kLight, 0.5f * kDot * width_px, out.paths);
  add_dot(last, kLight, kDot * width_px + 2 * seam_px, out.paths);
  add_dot(last, robot.color, kDot * width_px, out.paths);
}

void add_marker(const mapping::Pose& pose, const Color& color, float depth_m, float width_px, PathShapes& out) {
  const auto corner = pyramid(pose, depth_m);
  for (std::size_t i = 1; i < 5; ++i) {
    const glm::vec3 &a = corner[i], &b = corner[i % 4 + 1];
    out.edges.push_back({corner[0], a, with_alpha(color, 255), width_px});
    out.edges.push_back({a, b, with_alpha(color, 255), width_px});
    for (const glm::vec3& p : {corner[0], a, b}) out.faces.push_back({p, with_alpha(color, kFaceOpacity)});
  }
}

// Where a point stands in the picture, in heights of it; nothing behind the camera.
std::optional<glm::vec2> place(const glm::mat4& view_projection, float aspect, const glm::vec3& p) {
  const glm::vec4 clip = view_projection * glm::vec4(p, 1.0f);
  if (clip.w <= 0) return std::nullopt;
  return 0.5f * glm::vec2(aspect * clip.x / clip.w, clip.y / clip.w);
}

}  // namespace

PathShapes path_shapes(const Scene& scene, const Camera& camera, const Style& style) {
  const Markers markers = choose_markers(scene);
  const float least_m =
      kLeastDepth * camera.metres_per_pixel(camera.target, style.height_px) * static_cast<float>(style.height_px);
  const float depth_m = style.marker_size_m > 0 ? style.marker_size_m : std::max(markers.depth_m, least_m);
  const float aspect = static_cast<float>(style.width_px) / static_cast<float>(style.height_px);
  const glm::mat4 view_projection = camera.projection(aspect) * camera.view();
  PathShapes shapes;
  for (std::size_t r = 0; r < scene.robots.size(); ++r) {
    const RobotPath& robot = scene.robots[r];
    add_trajectory(robot, camera, style, shapes);
    std::vector<glm::vec2> taken;
    for (const std::size_t i : markers.keyframes[r]) {
      const auto at = place(view_projection, aspect, to_glm(robot.keyframe_poses[i].t));
      if (!at || std::ranges::any_of(taken, [&](const auto& p) { return glm::distance(p, *at) < kApart; })) continue;
      taken.push_back(*at);
      add_marker(robot.keyframe_poses[i], robot.color, depth_m, style.marker_width_px, shapes);
    }
  }
  return shapes;
}

}  // namespace onemap::render
