#include "local/tracking/keyframe_map.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "support/poses.hpp"

namespace onemap::mapping {
namespace {

// A robot before a wall 2 m away with features on it, a grid of 10 x 8; it moves along the wall.
struct Room {
  explicit Room(KeyframeMapConfig config = {12, 100, 0.10, 8})
      : depth(640 * 480, static_cast<std::uint16_t>(2 * k.depth_scale)), map(config, k) {}

  static Pose at(double x_m) { return {Matrix3d::Identity(), {-x_m, 0, 0}}; }  // T_camera_robot

  // What a camera at x_m sees, where no landmark is known.
  FeatureFrame see(double x_m) const {
    FeatureFrame out;
    for (int v = 0; v < 8; ++v)
      for (int u = 0; u < 10; ++u) {
        const Vector3d p(-0.9 + 0.2 * u - x_m, -0.7 + 0.2 * v, 2);
        Keypoint keypoint;
        keypoint.size_px = 20;
        out.set.keypoints.push_back(keypoint);
        out.set.descriptors.emplace_back();
        out.ray.emplace_back(p.head<2>() / 2);
        out.point.push_back(p);
        out.landmark.push_back(-1);
      }
    return out;
  }
  // The same with the landmarks that the reference knows.
  FeatureFrame see_again(double x_m) const {
    FeatureFrame out = see(x_m);
    out.landmark = map.reference().features.landmark;
    return out;
  }
  std::optional<std::size_t> add(double x_m, FeatureFrame features) {
    hal::FrameView frame;
    frame.intrinsics = &k;
    frame.depth = depth;
    frame.colour_time = frame.depth_time = FrameTime{} + std::chrono::milliseconds(static_cast<int>(1000 * x_m) + 1);
    return map.add(frame, at(x_m), features);
  }
  hal::Intrinsics k;
  std::vector<std::uint16_t> depth;
  KeyframeMap map;
};

TEST(KeyframeMap, TheFirstKeyframeMakesALandmarkOfEachFeatureWithAMeasurableDepth) {
  Room room;
  EXPECT_TRUE(room.map.empty());
  EXPECT_TRUE(room.map.follow(room.see(0), Pose{}, 80)) << "the first frame becomes a keyframe";
  FeatureFrame features = room.see(0);
  features.point[3].setZero();  // no depth
  features.point[4] *= 3.1;     // 6.2 m: too far
  EXPECT_FALSE(room.add(0, features));
  EXPECT_EQ(room.map.made(), 1u);
  EXPECT_EQ(room.map.near().size(), 78u);
  const MapKeyframe& k = room.map.reference();
  EXPECT_EQ(k.features.landmark[3], -1);
  EXPECT_EQ(k.features.landmark[4], -1);
  EXPECT_LT((room.map.landmarks().landmark(k.features.landmark[0]).p_robot - features.point[0]).norm(), 1e-12);
  EXPECT_NEAR(room.map.reference_cloud().points[60 * 160 + 80].z(), 2, 1e-3);
}

TEST(KeyframeMap, AFrameThatMovedEnoughOrKnowsLittleWantsToBeAKeyframe) {
  Room room;
  room.add(0, room.see(0));
  FeatureFrame many = room.see_again(0);
  many.set.keypoints.resize(100);
  EXPECT_FALSE(room.map.follow(many, Pose{}, 24)) << "the reference is new";
  EXPECT_FALSE(room.map.follow(room.see_again(0.09), Room::at(0.09), 80));
  EXPECT_TRUE(room.map.follow(room.see_again(0.11), Room::at(0.11), 80));
  EXPECT_FALSE(room.map.follow(room.see_again(0.11), Room::at(0.11), 19)) << "placed by too few to be relied on";
  const Pose turned{test::rotation({0, 1, 0}, 0.15), Vector3d::Zero()};  // 8.6 degrees
  EXPECT_TRUE(room.map.follow(room.see_again(0), turned, 80));
  EXPECT_TRUE(room.map.follow(many, Pose{}, 24)) << "it knows less than a quarter of its features";
  EXPECT_FALSE(room.map.follow(many, Pose{}, 25));
}

TEST(KeyframeMap, AKeyframeIsSealedWhenItLeavesTheWindowAndTakenOnce) {
  Room room;
  room.add(0, room.see(0));
  for (std::size_t i = 1; i < kWindow; ++i)
    EXPECT_FALSE(room.add(0.11 * static_cast<double>(i), room.see_again(0.11 * static_cast<double>(i))));
  EXPECT_EQ(room.map.take_sealed(), nullptr);
  const auto sealed = room.add(0.88, room.see_again(0.88));
  ASSERT_TRUE(sealed);
  const MapKeyframe* first = room.map.take_sealed();
  ASSERT_NE(first, nullptr);
  EXPECT_EQ(first, &room.map.landmarks().keyframe(*sealed));
  EXPECT_EQ(first->index, 0u);
  EXPECT_EQ(room.map.take_sealed(), nullptr);
  std::size_t rest = 0;
  while (room.map.seal_oldest()) ++rest;
  EXPECT_EQ(rest, kWindow);
}

TEST(KeyframeMap, BundleAdjustmentMovesAKeyframeThatWasPlacedWrongly) {
  Room room;
  room.add(0, room.see(0));
  FeatureFrame features = room.see_again(0.2);
  hal::FrameView frame;
  frame.intrinsics = &room.k;
  frame.depth = room.depth;
  room.map.add(frame, Room::at(0.23), features);  // 3 cm off
  EXPECT_NEAR(room.map.reference().T_camera_robot.t.x(), -0.2, 0.005);
}

TEST(KeyframeMap, TheReferenceIsTheKeyframeThatSharesMostLandmarks) {
  Room room;
  room.add(0, room.see(0));
  const std::size_t first = room.map.reference_slot();
  const FeatureFrame of_first = room.see_again(0);
  FeatureFrame half = room.see_again(0.3);  // knows half of the first's landmarks, and makes others
  for (std::size_t i = 0; i < 40; ++i) half.landmark[i] = -1;
  room.add(0.3, half);
  const std::size_t second = room.map.reference_slot();
  ASSERT_NE(first, second);
  room.map.follow(room.see_again(0.3), Room::at(0.3), 80);
  EXPECT_EQ(room.map.reference_slot(), second);
  room.map.follow(of_first, Room::at(0.02), 80);
  EXPECT_EQ(room.map.reference_slot(), first);
  EXPECT_NEAR(room.map.reference_cloud().points[60 * 160 + 80].z(), 2, 2e-3) << "restored from what it kept";
}

TEST(KeyframeMap, WhatMadeRoomIsForgottenByTheFrameThatNeededIt) {
  Room room({10, 80, 0.1, 8});  // 400 landmarks: five frames without common ones
  room.add(0, room.see(0));
  const std::vector<std::int32_t> of_first = room.map.reference().features.landmark;
  for (int i = 1; i < 9; ++i) room.add(i, room.see(i));
  FeatureFrame last = room.see(9);
  last.landmark = of_first;  // it knows what only the first keyframe sees, which goes to make room for it
  room.add(9, last);
  EXPECT_GT(room.map.landmarks().evicted(), 0u);
  EXPECT_EQ(room.map.made(), 10u);
  for (const std::int32_t id : room.map.reference().features.landmark)
    EXPECT_TRUE(id < 0 || room.map.landmarks().landmark(id).used);
}

}  // namespace
}  // namespace onemap::mapping
