#include "render/camera.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>
#include <vector>

namespace onemap::render {
namespace {

constexpr std::size_t kMaxSamples = 20000;  // points that decide a viewpoint
constexpr float kMargin = 1.04f;            // free border around what must be in view
constexpr float kBeyond = 0.05f;            // of the percentile box, on each side
constexpr float kLookDown = 0.3f;           // tangent of the fit view's tilt

glm::vec3 to_glm(const mapping::Vector3f& v) { return {v.x(), v.y(), v.z()}; }
glm::vec3 to_glm(const mapping::Vector3d& v) { return to_glm(mapping::Vector3f(v.cast<float>())); }

const std::vector<mapping::Vector3f>& map_points(const Scene& scene) {
  return scene.mesh.vertices.empty() ? scene.points.points : scene.mesh.vertices;
}

// A right-handed frame to look in: x right, y up, z towards the viewer's far side.
struct Frame {
  glm::vec3 right, up, forward;
};

Frame make_frame(const glm::vec3& forward, const glm::vec3& up) {
  const glm::vec3 f = glm::normalize(forward);
  glm::vec3 right = glm::cross(f, up);
  if (glm::length(right) < 1e-3f) right = glm::cross(f, std::abs(f.x) < 0.9f ? glm::vec3(1, 0, 0) : glm::vec3(0, 0, 1));
  right = glm::normalize(right);
  return {right, glm::cross(right, f), f};
}

template <class Visit>
void for_each_pose(const Scene& scene, const Visit& visit) {
  for (const RobotPath& robot : scene.robots)
    for (const auto& pose : robot.keyframe_poses.empty() ? robot.poses : robot.keyframe_poses) visit(pose);
}

// How the cameras looked on average; a frame's own axes without cameras. Cameras that turned around once have no mean
// direction: then the way from their middle to the map's middle counts.
Frame mean_frame(const Scene& scene, const glm::vec3& map_center) {
  glm::vec3 forward{0}, up{0}, position{0};
  float count = 0;
  for_each_pose(scene, [&](const mapping::Pose& pose) {
    forward += to_glm(mapping::Vector3d(pose.R.col(2)));
    up -= to_glm(mapping::Vector3d(pose.R.col(1)));
    position += to_glm(pose.t);
    count += 1;
  });
  if (count == 0) return make_frame({0, 0, 1}, {0, -1, 0});
  if (glm::length(up) < 0.1f * count) up = {0, -1, 0};
  up = glm::normalize(up);
  if (glm::length(forward) < 0.3f * count) forward = map_center - position / count;
  forward -= up * glm::dot(forward, up);  // level: the tilt is the view's affair
  if (glm::length(forward) < 1e-3f) forward = {0, 0, 1};
  return make_frame(forward, up);
}

// Every n-th point so that at most kMaxSamples remain.
std::vector<glm::vec3> sample_map(const Scene& scene) {
  const auto& points = map_points(scene);
  const std::size_t step = points.size() / kMaxSamples + 1;
  std::vector<glm::vec3> samples;
  for (std::size_t i = 0; i < points.size(); i += step)
    if (points[i].allFinite()) samples.push_back(to_glm(points[i]));
  return samples;
}

glm::vec3 middle(const std::vector<glm::vec3>& points) {
  glm::vec3 sum{0};
  for (const glm::vec3& p : points) sum += p;
  return points.empty() ? glm::vec3{0} : sum / static_cast<float>(points.size());
}

// Keeps the points between the 2nd and the 98th percentile, and a little beyond, along each axis of the frame.
std::vector<glm::vec3> without_strays(const std::vector<glm::vec3>& points, const Frame& frame) {
  if (points.size() < 50) return points;
  std::array<float, 3> low{}, high{};
  const std::array<glm::vec3, 3> axes{frame.right, frame.up, frame.forward};
  std::vector<float> along(points.size());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::transform(points.begin(), points.end(), along.begin(), [&](const auto& p) { return glm::dot(p, axes[axis]); });
    std::sort(along.begin(), along.end());
    const float p2 = along[along.size() / 50], p98 = along[along.size() - 1 - along.size() / 50];
    low[axis] = p2 - kBeyond * (p98 - p2);
    high[axis] = p98 + kBeyond * (p98 - p2);
  }
  std::vector<glm::vec3> kept;
  for (const glm::vec3& p : points) {
    bool inside = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float x = glm::dot(p, axes[axis]);
      inside = inside && x >= low[axis] && x <= high[axis];
    }
    if (inside) kept.push_back(p);
  }
  return kept;
}

// The nearest eye that looks along the frame's forward and has all points in its field of view. A point is right of the
// left edge if x - ex >= -(z - ez) t, and so on: linear in the eye, so the extremes of x -+ z t give it exactly.
glm::vec3 eye_that_sees(const std::vector<glm::vec3>& points, const Frame& frame, float tan_x, float tan_y) {
  const float huge = std::numeric_limits<float>::max();
  glm::vec2 high{-huge}, low{huge};
  for (const glm::vec3& p : points) {
    const float x = glm::dot(p, frame.right), y = glm::dot(p, frame.up), z = glm::dot(p, frame.forward);
    high = glm::max(high, glm::vec2(x - z * tan_x, y - z * tan_y));
    low = glm::min(low, glm::vec2(x + z * tan_x, y + z * tan_y));
  }
  const glm::vec2 middle_xy = 0.5f * (high + low);
  const float z = std::min((low.x - high.x) / (2 * tan_x), (low.y - high.y) / (2 * tan_y));
  return middle_xy.x * frame.right + middle_xy.y * frame.up + z * frame.forward;
}

void enclose(const Scene& scene, Camera& camera) {
  float farthest = 1.0f;
  const auto reach = [&](const glm::vec3& p) { farthest = std::max(farthest, glm::distance(p, camera.eye)); };
  for (const auto& p : map_points(scene)) {
    if (p.allFinite()) reach(to_glm(p));
  }
  for_each_pose(scene, [&](const mapping::Pose& pose) { reach(to_glm(pose.t)); });
  camera.far_m = 1.05f * farthest;
  camera.near_m = std::max(0.02f, camera.far_m / 5000.0f);
}

Camera look(const Scene& scene, const glm::vec3& eye, const Frame& frame, float distance) {
  Camera camera;
  camera.eye = eye;
  camera.target = eye + frame.forward * distance;
  camera.up = frame.up;
  enclose(scene, camera);
  return camera;
}

Camera see_all(const Scene& scene, std::vector<glm::vec3> must_see, const Frame& frame, float aspect) {
  for (const RobotPath& robot : scene.robots)
    for (const auto& pose : robot.poses.empty() ? robot.keyframe_poses : robot.poses)
      must_see.push_back(to_glm(pose.t));
  if (must_see.empty()) must_see.emplace_back(0.0f);
  const float tan_y = std::tan(0.5f * Camera{}.fov_y_rad) / kMargin;
  glm::vec3 eye = eye_that_sees(must_see, frame, tan_y * aspect, tan_y);
  const float distance = std::max(glm::dot(middle(must_see) - eye, frame.forward), 0.0f);
  if (distance < 0.2f) eye -= frame.forward * 0.2f;  // a single point
  return look(scene, eye, frame, std::max(distance, 0.2f));
}

// From behind (and above) one camera pose.
Camera see_along(const Scene& scene, const mapping::Pose& pose, float behind_m, float above_m) {
  const glm::vec3 forward = to_glm(mapping::Vector3d(pose.R.col(2))), up = -to_glm(mapping::Vector3d(pose.R.col(1)));
  const glm::vec3 position = to_glm(pose.t);
  const glm::vec3 eye = position - behind_m * forward + above_m * up;
  const glm::vec3 target = position + 1.5f * forward;
  return look(scene, eye, make_frame(target - eye, up), glm::distance(eye, target));
}

}  // namespace

glm::mat4 Camera::view() const { return glm::lookAt(eye, target, up); }
glm::mat4 Camera::projection(float aspect) const { return glm::perspective(fov_y_rad, aspect, near_m, far_m); }

std::optional<View> view_from_name(std::string_view name) {
  if (name == "fit") return View::fit;
  if (name == "top") return View::top;
  if (name == "front") return View::front;
  if (name == "follow") return View::follow;
  return std::nullopt;
}

Camera make_camera(const Scene& scene, View view, float aspect) {
  const RobotPath* robot = scene.robots.empty() ? nullptr : &scene.robots.front();
  if (view == View::front) {
    const bool known = robot != nullptr && !robot->keyframe_poses.empty();
    return see_along(scene, known ? robot->keyframe_poses.front() : mapping::Pose{}, 0.3f, 0.0f);
  }
  if (view == View::follow) {
    mapping::Pose last;
    if (robot != nullptr && !robot->keyframe_poses.empty()) last = robot->keyframe_poses.back();
    return see_along(scene, last, 0.9f, 0.45f);
  }
  const std::vector<glm::vec3> map = sample_map(scene);
  const Frame level = mean_frame(scene, middle(map));
  const Frame frame = view == View::top ? make_frame(-level.up, level.forward)
                                        : make_frame(level.forward - kLookDown * level.up, level.up);
  return see_all(scene, without_strays(map, level), frame, aspect);
}

Camera make_camera(const Scene& scene, const glm::vec3& eye, const glm::vec3& target) {
  const glm::vec3 up = mean_frame(scene, middle(sample_map(scene))).up;
  const float distance = glm::distance(eye, target);
  const glm::vec3 forward = distance > 1e-6f ? target - eye : glm::vec3(0, 0, 1);
  return look(scene, eye, make_frame(forward, up), std::max(distance, 1e-3f));
}

}  // namespace onemap::render
