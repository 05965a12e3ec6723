#include "render/camera.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "render/upright.hpp"
#include "room_scene.hpp"

namespace onemap::render {
namespace {

constexpr float kAspect = 16.0f / 9;

// Normalised device coordinates; w <= 0: behind the camera.
glm::vec4 project(const Camera& camera, const mapping::Vector3f& p) {
  const glm::vec4 clip = camera.projection(kAspect) * camera.view() * glm::vec4(p.x(), p.y(), p.z(), 1);
  return {clip.x / clip.w, clip.y / clip.w, clip.z / clip.w, clip.w};
}

bool in_view(const Camera& camera, const mapping::Vector3f& p) {
  const glm::vec4 q = project(camera, p);
  return q.w > 0 && std::abs(q.x) <= 1 && std::abs(q.y) <= 1 && std::abs(q.z) <= 1;
}

// Is the surface at this vertex drawn, seen from the camera? Walls are looked through from outside.
bool drawn(const Scene& scene, std::size_t vertex, const Camera& camera) {
  const auto& p = scene.mesh.vertices[vertex];
  const glm::vec3 to_eye = camera.eye - glm::vec3(p.x(), p.y(), p.z());
  const auto& n = scene.mesh.normals[vertex];
  return glm::dot(glm::vec3(n.x(), n.y(), n.z()), to_eye) > 0;
}

TEST(Viewpoint, fit_top_and_plan_show_all_that_is_drawn_with_a_border_and_no_more) {
  const Scene scene = test::room_scene();
  for (const View view : {View::fit, View::top, View::plan}) {
    const Camera camera = make_camera(scene, view, kAspect);
    float reach_x = 0, reach_y = 0;
    const auto see = [&](const mapping::Vector3f& p) {
      const glm::vec4 q = project(camera, p);
      ASSERT_GT(q.w, 0);
      ASSERT_LE(std::abs(q.z), 1);
      reach_x = std::max(reach_x, std::abs(q.x));
      reach_y = std::max(reach_y, std::abs(q.y));
    };
    for (const RobotPath& robot : scene.robots) {
      for (const auto& pose : robot.poses) see(pose.t.cast<float>());
      for (const auto& pose : robot.keyframe_poses) {  // and the base of a pyramid
        EXPECT_TRUE(in_view(camera, (pose * mapping::Vector3d(0.1, 0.1, 0.2)).cast<float>()));
      }
    }
    for (std::size_t i = 0; i < scene.mesh.vertices.size(); ++i)
      if (drawn(scene, i, camera)) see(scene.mesh.vertices[i]);
    EXPECT_LT(reach_x, 0.85f);
    EXPECT_LT(reach_y, 0.85f);
    EXPECT_GT(std::max(reach_x, reach_y), 0.8f);
  }
}

TEST(Viewpoint, a_plan_is_orthographic_and_keeps_lengths) {
  const Camera camera = make_camera(test::room_scene(), View::plan, kAspect);
  ASSERT_GT(camera.height_m, 0);
  EXPECT_GT(glm::normalize(camera.target - camera.eye).y, 0.999f);
  // Two places a metre apart, high and low, near and far: everywhere the same length, in heights of the picture.
  const auto length = [&](const mapping::Vector3f& from, const mapping::Vector3f& way) {
    const glm::vec4 a = project(camera, from), b = project(camera, from + way);
    return std::hypot(kAspect * (b.x - a.x), b.y - a.y) / 2;
  };
  for (const mapping::Vector3f& from : {mapping::Vector3f(0, -0.9f, 0), mapping::Vector3f(1, 1.4f, 3)})
    for (const mapping::Vector3f& way : {mapping::Vector3f(1, 0, 0), mapping::Vector3f(0, 0, 1)})
      EXPECT_NEAR(length(from, way), 1 / camera.height_m, 1e-4f);
  EXPECT_NEAR(camera.metres_per_pixel({0, 0, 0}, 720), camera.height_m / 720, 1e-6f);
}

TEST(Viewpoint, a_turntable_keeps_height_and_distance) {
  const Camera first = make_camera(test::room_scene(), View::fit, kAspect);
  const Camera half = turned_about_target(first, {0, -1, 0}, 0.5f);
  EXPECT_NEAR(half.eye.y, first.eye.y, 1e-4f);
  EXPECT_NEAR(glm::distance(half.eye, half.target), glm::distance(first.eye, first.target), 1e-3f);
  EXPECT_NEAR(half.eye.x - half.target.x, first.target.x - first.eye.x, 1e-3f);
  const Camera whole = turned_about_target(first, {0, -1, 0}, 1.0f);
  EXPECT_LT(glm::distance(whole.eye, first.eye), 1e-4f);
}

TEST(Viewpoint, fit_stands_behind_and_above_the_cameras_and_top_straight_above) {
  const Scene scene = test::room_scene();  // the robots look along +z, y is down
  const Camera fit = make_camera(scene, View::fit, kAspect);
  const glm::vec3 forward = glm::normalize(fit.target - fit.eye);
  EXPECT_LT(fit.eye.z, -0.7f);
  EXPECT_LT(fit.eye.y, -0.2f);
  EXPECT_GT(forward.z, 0.8f);
  EXPECT_GT(forward.y, 0.1f);
  const Camera top = make_camera(scene, View::top, kAspect);
  EXPECT_GT(glm::normalize(top.target - top.eye).y, 0.999f);
  EXPECT_GT(std::max(std::abs(top.up.z), std::abs(top.up.x)), 0.99f) << "walls lie along the rims";
}

// A long room that lies askew in its frame, seen all around from its middle: the picture's floor lines are level.
TEST(Viewpoint, a_dolls_house_is_seen_along_its_walls) {
  for (const double turn : {0.0, 0.3, 0.61, 1.2}) {
    Scene scene;
    test::add_box(scene.mesh, {-4, -1, -1}, {4, 1.4f, 1}, true, 8, {});
    const mapping::Matrix3d R = test::level_pose(0, 0, 0, turn).R;
    scene.mesh = turned(std::move(scene.mesh), R);
    scene.robots.resize(1);
    for (int i = 0; i < 8; ++i)
      scene.robots[0].keyframe_poses.push_back(test::level_pose(0, 0, 0, i * 0.7853981634 + turn));
    const Camera fit = make_camera(scene, View::fit, kAspect);
    const glm::vec3 right = glm::normalize(glm::cross(fit.target - fit.eye, fit.up));
    const mapping::Vector3d wall = R.col(0);  // the long one's direction
    const double along = std::abs(right.x * wall.x() + right.y * wall.y() + right.z * wall.z());
    EXPECT_GT(along, 0.9998) << turn;
  }
}

TEST(Viewpoint, a_few_stray_points_do_not_move_the_camera) {
  Scene scene = test::room_scene();
  const Camera before = make_camera(scene, View::fit, kAspect);
  for (int i = 0; i < 5; ++i) scene.mesh.vertices.emplace_back(50.0f, -40.0f, 300.0f);
  const Camera after = make_camera(scene, View::fit, kAspect);
  EXPECT_LT(glm::distance(before.eye, after.eye), 0.6f);
  EXPECT_GT(after.far_m, 300.0f);
}

TEST(Viewpoint, front_and_follow_stand_behind_the_first_robots_keyframes) {
  Scene scene = test::room_scene();
  scene.robots[0].keyframe_poses = {test::level_pose(1, 0, 0, 1.5707963), test::level_pose(0, 0, 2, 0)};
  const Camera front = make_camera(scene, View::front, kAspect);  // yaw of a quarter turn: looks along +x
  EXPECT_GT(glm::normalize(front.target - front.eye).x, 0.999f);
  EXPECT_LT(front.eye.x, 1.0f);
  const Camera follow = make_camera(scene, View::follow, kAspect);
  EXPECT_LT(follow.eye.z, 1.5f);
  EXPECT_LT(follow.eye.y, -0.2f);
  EXPECT_TRUE(in_view(follow, {0, 0, 2}));
}

TEST(Viewpoint, a_turntable_shows_all_from_every_side) {
  const Scene scene = test::room_scene();
  const Camera camera = with_room_to_turn(scene, make_camera(scene, View::fit, kAspect), kAspect);
  for (int i = 0; i < 12; ++i) {
    const Camera side = turned_about_target(camera, {0, -1, 0}, static_cast<float>(i) / 12);
    for (std::size_t v = 0; v < scene.mesh.vertices.size(); ++v) {
      if (drawn(scene, v, side)) {
        EXPECT_TRUE(in_view(side, scene.mesh.vertices[v])) << i;
      }
    }
  }
}

bool sane(const Camera& camera) {
  const glm::mat4 m = camera.projection(kAspect) * camera.view();
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r)
      if (!std::isfinite(m[c][r])) return false;
  return camera.near_m > 0 && camera.far_m > camera.near_m;
}

TEST(Viewpoint, every_scene_gives_a_usable_camera) {
  Scene empty, single, turned;
  single.points.points = {{1, 2, 3}};
  for (int i = 0; i < 8; ++i)
    turned.robots.resize(1), turned.robots[0].keyframe_poses.push_back(test::level_pose(0, 0, 0, i * 0.7853981634));
  for (const Scene* scene : {&empty, &single, &turned}) {
    for (const View view : {View::fit, View::top, View::plan, View::front, View::follow})
      EXPECT_TRUE(sane(make_camera(*scene, view, kAspect)));
    EXPECT_TRUE(sane(make_camera(*scene, {1, 1, 1}, {1, 1, 1})));
    EXPECT_TRUE(sane(make_camera(*scene, {0, -3, 0}, {0, 0, 0})));  // straight down: up is parallel
  }
  EXPECT_TRUE(in_view(make_camera(single, View::fit, kAspect), {1, 2, 3}));
}

TEST(Viewpoint, names) {
  EXPECT_EQ(view_from_name("top"), View::top);
  EXPECT_EQ(view_from_name("fit"), View::fit);
  EXPECT_EQ(view_from_name("plan"), View::plan);
  EXPECT_EQ(view_from_name("sideways"), std::nullopt);
}

}  // namespace
}  // namespace onemap::render
