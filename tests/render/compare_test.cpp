#include "render/compare.hpp"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "render/figures.hpp"
#include "render/upright.hpp"
#include "room_scene.hpp"

namespace onemap::render {
namespace {

// A floor that a robot sees from twenty keyframes along it.
Scene walk_over_a_floor() {
  Scene scene;
  test::add_tiles(scene.mesh, {-1, 1.5f, -1}, {0, 0, 12}, {2, 0, 0}, 120, {90, 90, 90}, {90, 90, 90});
  scene.robots = {{"robot1", {}, {}, {}}};
  for (int i = 0; i < 20; ++i) scene.robots[0].keyframe_poses.push_back(test::level_pose(0.1 * (i % 3), 0, 0.5 * i, 0));
  return scene;
}

// The same in a frame of its own.
Scene elsewhere(Scene scene) {
  const mapping::Pose T{test::level_pose(0, 0, 0, 0.7).R, {3, -1, 2}};
  scene.mesh = turned(std::move(scene.mesh), T.R);
  for (auto& vertex : scene.mesh.vertices) vertex += T.t.cast<float>();
  for (auto& pose : scene.robots[0].keyframe_poses) pose = T * pose;
  return scene;
}

glm::vec3 in_frame(const Scene& whole, const Scene& map, const glm::vec3& v) {
  const mapping::Vector3d turned = motion_between(whole, map)->R * mapping::Vector3d(v.x, v.y, v.z);
  return {turned.x(), turned.y(), turned.z()};
}

float median_m(const Scene& of, const Scene& to) {
  return summary(distances_m(of.mesh, in_frame_of(to, of).mesh, 0.05f), 0.05f).median_m;
}

TEST(Compare, MapsOfOneRobotAreBroughtTogetherByItsKeyframes) {
  const Scene scene = walk_over_a_floor();
  EXPECT_LT(median_m(scene, elsewhere(scene)), 1e-4f);
  Scene strange = elsewhere(scene);
  strange.robots[0].name = "robot2";
  EXPECT_GT(median_m(scene, strange), 0.04f) << "nothing in common";
}

// A degree at the first keyframe would be 20 cm at the end of the floor.
TEST(Compare, OneKeyframeThatIsOffDoesNotTurnTheMap) {
  const Scene scene = walk_over_a_floor();
  Scene other = elsewhere(scene);
  auto& first = other.robots[0].keyframe_poses.front();
  first.R = first.R * Eigen::AngleAxisd(0.0175, mapping::Vector3d::UnitX()).toRotationMatrix();
  EXPECT_LT(median_m(scene, other), 0.006f);
  other.robots[0].keyframe_poses.pop_back();  // no longer the same ones: by the first alone
  EXPECT_GT(median_m(scene, other), 0.04f);
}

TEST(Compare, TheSummaryCountsWhatIsBeyondTheLimit) {
  std::vector<float> distances;
  for (int i = 1; i <= 100; ++i) distances.push_back(std::min(0.001f * static_cast<float>(i), 0.05f));
  const DistanceSummary s = summary(distances, 0.05f);
  EXPECT_NEAR(s.median_m, 0.050f, 1e-6f);
  EXPECT_NEAR(s.beyond, 0.51f, 1e-6f);
  EXPECT_EQ(distance_color(0, 0.05f), (mapping::Rgb{45, 60, 150}));
  EXPECT_EQ(distance_color(1, 0.05f), (mapping::Rgb{200, 40, 40}));
}

// Figure 10: whatever way a robot's own frame is turned, maps of one team are seen in one direction and at one scale.
TEST(Beside, MapsOfATeamAreSeenAsTheWholeIs) {
  const Scene whole = walk_over_a_floor();
  Scene small = whole;
  small.mesh = {};
  small.robots[0].keyframe_poses.resize(5);
  test::add_tiles(small.mesh, {-1, 1.5f, -1}, {0, 0, 3}, {2, 0, 0}, 30, {90, 90, 90}, {90, 90, 90});
  Scene stranger = elsewhere(whole);
  stranger.robots[0].name = "robot9";
  const std::vector<Scene> maps{whole, elsewhere(small), stranger};
  const Camera common = make_camera(whole, View::fit, 16.0f / 9);
  const std::vector<float> aspects(3, 1.5f);
  const std::vector<Camera> cameras = cameras_beside(maps, aspects, &whole);
  ASSERT_EQ(cameras.size(), 3u);
  for (std::size_t i = 0; i < 2; ++i) {
    const auto along = [](const glm::vec3& a, const glm::vec3& b) {
      return glm::dot(glm::normalize(a), glm::normalize(b));
    };
    const glm::vec3 way = in_frame(whole, maps[i], cameras[i].target - cameras[i].eye);
    EXPECT_GT(along(way, common.target - common.eye), 0.9999f) << i;
    EXPECT_GT(along(in_frame(whole, maps[i], cameras[i].up), common.up), 0.9999f) << i;
    EXPECT_NEAR(glm::distance(cameras[i].eye, cameras[i].target), glm::distance(cameras[0].eye, cameras[0].target),
                1e-3);
    EXPECT_GT(cameras[i].far_m, glm::distance(cameras[i].eye, cameras[i].target));
  }
  EXPECT_EQ(cameras[2].eye, make_camera(stranger, View::fit, 1.5f).eye) << "nobody knows where that one is";
  EXPECT_EQ(cameras_beside(maps, aspects, nullptr)[1].eye, make_camera(maps[1], View::fit, 1.5f).eye);
}

// At one scale the widest map says how large all are; with more of the row for it they are larger.
TEST(Beside, AWideMapHasMoreOfItsRow) {
  const Scene whole = walk_over_a_floor();
  Scene narrow = whole;
  narrow.mesh = {};
  narrow.robots[0].keyframe_poses.resize(4);
  test::add_tiles(narrow.mesh, {-0.5f, 1.5f, 1}, {0, 0, 1}, {1, 0, 0}, 30, {90, 90, 90}, {90, 90, 90});
  const std::vector<Scene> maps{narrow, whole, narrow, whole, narrow};
  const std::vector<float> even(5, 0.5f), aspects = aspects_beside(maps, 0.5f, 3, &whole);
  EXPECT_LT(aspects[0], 0.4f);
  EXPECT_GT(aspects[1], 0.65f);
  EXPECT_NEAR(aspects[0], aspects[2], 1e-3f);
  EXPECT_NEAR(aspects[0] + aspects[1] + aspects[2], 1.5, 1e-3f);
  EXPECT_NEAR(aspects[3] + aspects[4], 1, 1e-3f) << "the second row";
  const auto distance_m = [](const Camera& camera) { return glm::distance(camera.eye, camera.target); };
  EXPECT_LT(distance_m(cameras_beside(maps, aspects, &whole)[1]),
            0.95f * distance_m(cameras_beside(maps, even, &whole)[1]));
  EXPECT_EQ(aspects_beside(maps, 0.5f, 3, nullptr), even) << "each at its own scale";
}

}  // namespace
}  // namespace onemap::render
