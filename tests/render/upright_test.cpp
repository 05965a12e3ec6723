#include "render/upright.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "render/ply_reader.hpp"
#include "render/ply_writer.hpp"
#include "room_scene.hpp"
#include "simulated_room.hpp"
#include "temp_folder.hpp"

namespace onemap::render {
namespace {

using mapping::Vector3d;
using mapping::Vector3f;

double degrees_between(const Vector3f& a, const Vector3f& b) {
  return std::acos(std::min(1.0f, a.normalized().dot(b.normalized()))) * 57.29578;
}

// A turn about an axis by degrees.
mapping::Matrix3d turn(const Vector3d& axis, double degrees) {
  const double half = degrees / 57.29578 / 2;
  const Vector3d v = axis.normalized() * std::sin(half);
  return mapping::from_quaternion_wxyz({std::cos(half), v.x(), v.y(), v.z()});
}

// The scene as a robot sees it whose first camera was tilted.
Scene tilted(Scene scene, const mapping::Matrix3d& R) {
  scene.mesh = turned(std::move(scene.mesh), R);
  for (RobotPath& robot : scene.robots)
    for (auto* poses : {&robot.poses, &robot.keyframe_poses})
      for (mapping::Pose& pose : *poses) pose = mapping::Pose{R, {0, 0, 0}} * pose;
  return scene;
}

TEST(Upright, a_tilted_room_stands_upright_though_its_cameras_look_down) {
  for (const double tilt : {0.0, 12.0, 35.0}) {
    Scene scene = test::room_scene();
    for (RobotPath& robot : scene.robots)
      for (mapping::Pose& pose : robot.keyframe_poses) pose.R = pose.R * turn({1, 0, 0}, -tilt);  // eyes down
    const mapping::Matrix3d R = turn({1, 0.3, 0.2}, tilt);
    const Vector3f up = up_of(tilted(scene, R));
    EXPECT_LT(degrees_between(up, (R * Vector3d(0, -1, 0)).cast<float>()), 0.5) << tilt;
  }
}

TEST(Upright, without_surface_the_cameras_decide_and_without_cameras_minus_y) {
  EXPECT_LT(degrees_between(up_of({}), {0, -1, 0}), 1e-3);
  Scene scene;
  const mapping::Matrix3d R = turn({0, 0, 1}, 40);
  scene.robots = {{"robot1", {}, {}, {{R, {0, 0, 0}}, {R, {1, 0, 0}}}}};
  EXPECT_LT(degrees_between(up_of(scene), (R * Vector3d(0, -1, 0)).cast<float>()), 0.1);
}

TEST(Upright, the_rotation_brings_up_to_y_and_ahead_to_minus_z) {
  for (const Vector3f& up : {Vector3f(0, -1, 0), Vector3f(0.3f, -0.8f, 0.4f), Vector3f(0, 0, 1), Vector3f(0, 0, -1)}) {
    const mapping::Matrix3d R = upright_rotation(up);
    EXPECT_LT((R * up.normalized().cast<double>() - Vector3d(0, 1, 0)).norm(), 1e-6);
    EXPECT_LT((R * R.transpose() - mapping::Matrix3d::Identity()).norm(), 1e-6);
    EXPECT_NEAR(R.determinant(), 1, 1e-6);
    EXPECT_LT((R * Vector3d(0, 0, 1)).z(), 1e-6);
  }
}

TEST(Upright, a_ply_comes_upright_and_back) {
  const test::TempFolder folder;
  const auto mesh = test::room_scene().mesh;
  const mapping::Matrix3d R = upright_rotation({0.1f, -0.9f, 0.2f});
  ASSERT_TRUE(write_ply(folder / "a.ply", mesh, R).ok());
  const auto back = read_ply(folder / "a.ply");
  ASSERT_TRUE(back.ok()) << back.error().text();
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    ASSERT_LT((back->vertices[i] - mesh.vertices[i]).norm(), 1e-5f);
    ASSERT_LT((back->normals[i] - mesh.normals[i]).norm(), 1e-5f);
  }
  const std::string torn =
      "ply\nformat ascii 1.0\ncomment onemap rotation_file_map 1 0 0 x\nelement vertex 0\n"
      "property float x\nproperty float y\nproperty float z\nend_header\n";
  EXPECT_FALSE(parse_ply({reinterpret_cast<const std::uint8_t*>(torn.data()), torn.size()}, "t").ok());
}

TEST(Upright, simulated_rooms_stand_upright_within_three_degrees) {
  for (const char* text : {"simulated:living-room?frames=120&fps=8&width=320&height=240",
                           "simulated:office?frames=90&fps=8&width=320&height=240&robot=2",
                           "simulated:storage?frames=40&fps=8&width=320&height=240&seed=3",
                           "simulated:house?frames=144&fps=8&width=320&height=240"}) {
    const test::SimulatedRoom room = test::simulated_room(text);
    ASSERT_GT(room.scene.mesh.triangles.size(), 5000u) << text;
    EXPECT_LT(degrees_between(up_of(room.scene), room.up), 3.0) << text;
  }
}

}  // namespace
}  // namespace onemap::render
