#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

#include "markers.hpp"
#include "render/camera.hpp"
#include "render/upright.hpp"
#include "vectors.hpp"
#include "viewing_side.hpp"

namespace onemap::render {
namespace {

constexpr std::size_t kMostPoints = 100000;     // points that decide a viewpoint
constexpr float kMargin = 1 / (1 - 2 * 0.08f);  // 8 % of the picture stay free on each side
constexpr float kStrays = 0.003f, kBeyond = 0.04f;
constexpr float kOneWay = 0.6f;     // length of the mean viewing direction from which the cameras looked one way
constexpr float kLookDown = 0.36f;  // tangent of the fit view's tilt

const std::vector<mapping::Vector3f>& map_points(const Scene& scene) {
  return scene.mesh.vertices.empty() ? scene.points.points : scene.mesh.vertices;
}
const std::vector<mapping::Vector3f>& map_normals(const Scene& scene) {
  return scene.mesh.vertices.empty() ? scene.points.normals : scene.mesh.normals;
}

template <class Visit>
void for_each_pose(const Scene& scene, const Visit& visit) {
  for (const RobotPath& robot : scene.robots)
    for (const auto& pose : robot.keyframe_poses.empty() ? robot.poses : robot.keyframe_poses) visit(pose);
}

// Every n-th point so that at most kMostPoints remain, without the strays along the frame's axes.
std::vector<Sample> sample_map(const Scene& scene, const Frame& frame) {
  const auto &points = map_points(scene), &normals = map_normals(scene);
  const bool has_normals = normals.size() == points.size();
  const std::size_t step = points.size() / kMostPoints + 1;
  std::vector<Sample> samples;
  for (std::size_t i = 0; i < points.size(); i += step)
    if (points[i].allFinite())
      samples.push_back({to_glm(points[i]), has_normals ? to_glm(normals[i]) : glm::vec3(0.0f)});
  if (samples.size() < 50) return samples;
  std::vector<float> along(samples.size());
  for (const glm::vec3& axis : {frame.right, frame.up, frame.forward}) {
    along.resize(samples.size());
    std::transform(samples.begin(), samples.end(), along.begin(), [&](const Sample& s) { return dot(s.point, axis); });
    const auto skip = static_cast<std::ptrdiff_t>(kStrays * static_cast<float>(along.size()));
    const auto from = along.begin() + skip, to = along.end() - 1 - skip;
    std::nth_element(along.begin(), from, along.end());
    const float low = *from;
    std::nth_element(from, to, along.end());
    const float high = *to, beyond = kBeyond * (high - low);
    std::erase_if(samples, [&](const Sample& s) {
      const float x = glm::dot(s.point, axis);
      return x < low - beyond || x > high + beyond;
    });
  }
  return samples;
}

// Paths and camera pyramids: seen from everywhere.
void add_robots(const Scene& scene, std::vector<Sample>& samples) {
  const Markers markers = choose_markers(scene);
  for (std::size_t r = 0; r < scene.robots.size(); ++r) {
    const RobotPath& robot = scene.robots[r];
    for (const auto& pose : robot.poses) samples.push_back({to_glm(pose.t), glm::vec3(0.0f)});
    for (const std::size_t i : markers.keyframes[r])
      for (const glm::vec3& corner : pyramid(robot.keyframe_poses[i], markers.depth_m))
        samples.push_back({corner, glm::vec3(0.0f)});
  }
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

glm::vec3 middle(const std::vector<glm::vec3>& points) {
  glm::vec3 sum{0};
  for (const glm::vec3& p : points) sum += p;
  return points.empty() ? sum : sum / static_cast<float>(points.size());
}

// What is culled for its direction does not count, and what is depends on the eye: a few rounds settle it.
Camera see_all(const Scene& scene, const std::vector<Sample>& samples, const Frame& frame, float aspect) {
  const float tan_y = std::tan(0.5f * Camera{}.fov_y_rad) / kMargin;
  std::vector<glm::vec3> seen;
  glm::vec3 eye{0};
  for (int round = 0; round < 4; ++round) {
    seen.clear();
    for (const Sample& s : samples)
      if (faces(s, round == 0 ? -frame.forward : eye - s.point)) seen.push_back(s.point);
    if (seen.empty()) seen.emplace_back(0.0f);
    eye = eye_that_sees(seen, frame, tan_y * aspect, tan_y);
  }
  const float distance = std::max(glm::dot(middle(seen) - eye, frame.forward), 0.0f);
  if (distance < 0.2f) eye -= frame.forward * 0.2f;  // a single point
  return look(scene, eye, frame, std::max(distance, 0.2f));
}

Camera see_plan(const Scene& scene, const std::vector<Sample>& samples, const Frame& frame, float aspect) {
  const Box box = seen_box(samples, frame);
  const glm::vec3 size = box.high - box.low, centre = 0.5f * (box.low + box.high);
  const glm::vec3 eye = centre.x * frame.right + centre.y * frame.up + (box.low.z - 1.0f) * frame.forward;
  Camera camera = look(scene, eye, frame, 1.0f + std::max(size.z, 0.1f));
  camera.height_m = kMargin * std::max({size.y, size.x / aspect, 0.5f});
  return camera;
}

// The direction, level, in which the cameras looked on average; 0: all around.
glm::vec3 common_forward(const Scene& scene, const glm::vec3& up) {
  glm::vec3 forward{0};
  float count = 0;
  for_each_pose(scene, [&](const mapping::Pose& pose) {
    const glm::vec3 z = to_glm(mapping::Vector3d(pose.R.col(2))), level = z - up * glm::dot(z, up);
    forward += level;
    count += glm::length(level);
  });
  if (count == 0) forward = glm::normalize(some_level(up)), count = 1;
  return glm::length(forward) > std::max(kOneWay * count, 1e-3f) ? glm::normalize(forward) : glm::vec3(0);
}

// From behind (and above) one camera pose.
Camera see_along(const Scene& scene, const mapping::Pose& pose, float behind_m, float above_m) {
  const glm::vec3 forward = to_glm(mapping::Vector3d(pose.R.col(2))), up = -to_glm(mapping::Vector3d(pose.R.col(1)));
  const glm::vec3 position = to_glm(pose.t);
  const glm::vec3 eye = position - behind_m * forward + above_m * up;
  const glm::vec3 target = position + 1.5f * forward;
  return look(scene, eye, make_frame(target - eye, to_glm(up_of(scene))), glm::distance(eye, target));
}

}  // namespace

Camera camera_behind(const Scene& scene, const mapping::Pose& pose) { return see_along(scene, pose, 0.9f, 0.45f); }

Camera make_camera(const Scene& scene, View view, float aspect) {
  const RobotPath* robot = scene.robots.empty() ? nullptr : &scene.robots.front();
  const bool known = robot != nullptr && !robot->keyframe_poses.empty();
  if (view == View::front) return see_along(scene, known ? robot->keyframe_poses.front() : mapping::Pose{}, 0.3f, 0.0f);
  if (view == View::follow) return camera_behind(scene, known ? robot->keyframe_poses.back() : mapping::Pose{});

  const glm::vec3 up = to_glm(up_of(scene));
  const glm::vec3 ahead = common_forward(scene, up);
  const bool one_way = glm::length(ahead) > 0.5f;
  const Frame level = make_frame(one_way ? ahead : some_level(up), up);
  std::vector<Sample> samples = sample_map(scene, level);
  add_robots(scene, samples);
  const Frame side = one_way ? make_frame(ahead - kLookDown * up, up) : best_side(samples, up, aspect);
  if (view == View::fit) return see_all(scene, samples, side, aspect);
  const glm::vec3 away = side.forward - up * glm::dot(side.forward, up);
  const Frame down = from_above(samples, up, glm::length(away) > 1e-3f ? away : level.forward, aspect);
  return view == View::plan ? see_plan(scene, samples, down, aspect) : see_all(scene, samples, down, aspect);
}

Camera fit_along(const Scene& scene, const glm::vec3& forward, const glm::vec3& up, float aspect) {
  const Frame frame = make_frame(forward, up);
  std::vector<Sample> samples = sample_map(scene, frame);
  add_robots(scene, samples);
  return see_all(scene, samples, frame, aspect);
}

Camera with_room_to_turn(const Scene& scene, const Camera& camera, float aspect) {
  const glm::vec3 up = to_glm(up_of(scene));
  const float tan_y = std::tan(0.5f * camera.fov_y_rad) / kMargin;
  const Frame seen = make_frame(camera.target - camera.eye, up);
  std::vector<Sample> samples = sample_map(scene, seen);
  add_robots(scene, samples);
  float distance = glm::distance(camera.eye, camera.target), radius = 0;
  for (int i = 0; i < 24; ++i) {
    const Camera side = turned_about_target(camera, {up.x, up.y, up.z}, static_cast<float>(i) / 24);
    const Frame frame = make_frame(side.target - side.eye, up);
    for (const Sample& s : samples) {
      const glm::vec3 p = s.point - camera.target;
      radius = std::max(radius, glm::length(p));
      const float aside = std::abs(glm::dot(p, frame.right)) / (tan_y * aspect);
      distance =
          std::max(distance, std::max(aside, std::abs(glm::dot(p, frame.up)) / tan_y) - glm::dot(p, frame.forward));
    }
  }
  Camera out = look(scene, camera.target - seen.forward * distance, seen, distance);
  out.far_m = std::max(out.far_m, 1.05f * (distance + radius));
  return out;
}

Camera make_camera(const Scene& scene, const glm::vec3& eye, const glm::vec3& target) {
  const glm::vec3 up = to_glm(up_of(scene));
  const float distance = glm::distance(eye, target);
  const glm::vec3 forward = distance > 1e-6f ? target - eye : glm::vec3(0, 0, 1);
  return look(scene, eye, make_frame(forward, up), std::max(distance, 1e-3f));
}

}  // namespace onemap::render
