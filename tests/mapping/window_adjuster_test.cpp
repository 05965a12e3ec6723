#include "local/tracking/window_adjuster.hpp"

#include <gtest/gtest.h>

#include "support/poses.hpp"

namespace onemap::mapping {
namespace {

constexpr double kFocal_px = 525;
constexpr std::size_t kPoints = 120;

double uniform(std::uint64_t& state, double low, double high) {
  state = state * 6364136223846793005ull + 1442695040888963407ull;
  return low + (high - low) * static_cast<double>(state >> 11) / static_cast<double>(1ull << 53);
}

Pose true_pose(std::size_t i) {
  Vector6d wv;
  wv << 0.01 * static_cast<double>(i), -0.02 * static_cast<double>(i), 0, -0.05 * static_cast<double>(i),
      0.01 * static_cast<double>(i), 0;
  return small_motion(wv);
}

// Keyframes that all see the same points exactly; poses and landmarks are then disturbed.
struct Scene {
  explicit Scene(std::size_t keyframes) : map(16, 1000, kPoints) {
    std::uint64_t state = 3;
    for (std::size_t j = 0; j < kPoints; ++j) {
      const double z = uniform(state, 1, 3);
      truth.emplace_back(uniform(state, -0.5, 0.5) * z, uniform(state, -0.4, 0.4) * z, z);
      ids.push_back(map.add_landmark());
      map.landmark(ids[j]).observations = static_cast<std::uint16_t>(keyframes);
      map.landmark(ids[j]).p_robot =
          truth[j] + Vector3d(uniform(state, -0.02, 0.02), uniform(state, -0.02, 0.02), uniform(state, -0.02, 0.02));
    }
    for (std::size_t i = 0; i < keyframes; ++i) {
      MapKeyframe& k = map.keyframe(i);
      k.used = true;
      k.T_camera_robot = true_pose(i);
      for (std::size_t j = 0; j < kPoints; ++j) {
        const Vector3d p = true_pose(i) * truth[j];
        Keypoint keypoint;
        keypoint.size_px = 20;
        k.features.set.keypoints.push_back(keypoint);
        k.features.set.descriptors.emplace_back();
        k.features.ray.emplace_back(p.x() / p.z(), p.y() / p.z());
        k.features.point.push_back(p);
        k.features.landmark.push_back(ids[j]);
      }
      slots.push_back(i);
    }
  }
  void disturb(std::size_t i) {
    Vector6d wv;
    wv << 0.01, -0.008, 0.005, 0.02, -0.01, 0.015;
    map.keyframe(i).T_camera_robot = small_motion(wv) * map.keyframe(i).T_camera_robot;
  }
  double worst_pose() const {
    double worst = 0;
    for (const std::size_t i : slots) {
      const Pose d = true_pose(i).inverse() * map.keyframe(i).T_camera_robot;
      worst = std::max(worst, d.t.norm() + test::rotation_angle(d.R));
    }
    return worst;
  }
  double worst_point() const {
    double worst = 0;
    for (std::size_t j = 0; j < kPoints; ++j)
      if (map.landmark(ids[j]).used) worst = std::max(worst, (map.landmark(ids[j]).p_robot - truth[j]).norm());
    return worst;
  }
  LandmarkMap map;
  std::vector<Vector3d> truth;
  std::vector<std::int32_t> ids;
  std::vector<std::size_t> slots;
};

TEST(WindowAdjuster, FindsPosesAndLandmarksAgainWithTheFirstKeyframeHeld) {
  Scene scene(4);
  for (std::size_t i = 1; i < 4; ++i) scene.disturb(i);
  WindowAdjuster adjuster(500, 2000);
  for (int i = 0; i < 5; ++i) adjuster.adjust(scene.map, scene.slots, kFocal_px);
  EXPECT_LT(scene.worst_pose(), 1e-3);
  EXPECT_LT(scene.worst_point(), 2e-3);
}

TEST(WindowAdjuster, KeyframesOutsideTheWindowHoldItInPlace) {
  Scene scene(6);
  for (std::size_t i = 3; i < 6; ++i) scene.disturb(i);
  WindowAdjuster adjuster(500, 2000);
  const std::array<std::size_t, 3> window{3, 4, 5};
  for (int i = 0; i < 5; ++i) adjuster.adjust(scene.map, window, kFocal_px);
  EXPECT_LT(scene.worst_pose(), 1e-3);
  EXPECT_EQ(scene.map.keyframe(1).T_camera_robot.t, true_pose(1).t) << "a keyframe outside the window must not move";
}

TEST(WindowAdjuster, WrongObservationsAreUnlinked) {
  Scene scene(4);
  for (std::size_t j = 0; j < 10; ++j) scene.map.keyframe(3).features.ray[j] += Eigen::Vector2d(0.1, 0.1);
  WindowAdjuster adjuster(500, 2000);
  adjuster.adjust(scene.map, scene.slots, kFocal_px);
  for (std::size_t j = 0; j < kPoints; ++j) EXPECT_EQ(scene.map.keyframe(3).features.landmark[j] < 0, j < 10) << j;
  EXPECT_LT(scene.worst_pose(), 5e-3);
}

TEST(WindowAdjuster, SameInputGivesTheSameBits) {
  Scene a(5), b(5);
  WindowAdjuster one(500, 2000), two(500, 2000);
  a.disturb(2);
  b.disturb(2);
  one.adjust(a.map, a.slots, kFocal_px);
  two.adjust(b.map, b.slots, kFocal_px);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(a.map.keyframe(i).T_camera_robot.t, b.map.keyframe(i).T_camera_robot.t);
}

}  // namespace
}  // namespace onemap::mapping
