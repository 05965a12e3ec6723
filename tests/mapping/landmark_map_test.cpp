#include "local/tracking/landmark_map.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "local/tracking/guided_search.hpp"
#include "mapping/local/mapper_config.hpp"

namespace onemap::mapping {
namespace {

// A keyframe that sees count landmarks, new ones or those given.
void see(LandmarkMap& map, std::size_t slot, const std::vector<std::int32_t>& ids) {
  MapKeyframe& k = map.keyframe(slot);
  k.used = k.sealed = true;
  k.features.landmark = ids;
  k.features.set.keypoints.resize(ids.size());
  k.features.set.descriptors.resize(ids.size());
  k.features.ray.resize(ids.size());
  k.features.point.assign(ids.size(), Vector3d::Zero());
  for (const std::int32_t id : ids) ++map.landmark(id).observations;
}

std::vector<std::int32_t> add(LandmarkMap& map, std::size_t count) {
  std::vector<std::int32_t> ids;
  for (std::size_t i = 0; i < count; ++i) ids.push_back(map.add_landmark());
  return ids;
}

TEST(LandmarkMap, AFullPoolSaysSo) {
  LandmarkMap map(2, 3, 4);
  add(map, 3);
  EXPECT_EQ(map.add_landmark(), -1);
}

TEST(LandmarkMap, TheKeyframeWithTheFewestLandmarksOfItsOwnMakesRoom) {
  LandmarkMap map(3, 100, 50);
  const auto shared = add(map, 20);
  see(map, 0, shared);
  see(map, 1, shared);
  see(map, 2, shared);
  const auto own = add(map, 5);
  std::vector<std::int32_t> both = shared;
  both.insert(both.end(), own.begin(), own.end());
  map.keyframe(1).features.landmark = both;  // keyframe 1 alone sees five more
  map.keyframe(1).features.set.keypoints.resize(both.size());
  for (const std::int32_t id : own) ++map.landmark(id).observations;
  const std::array<std::size_t, 1> keep{0};
  EXPECT_EQ(map.take_keyframe_slot(keep), 2u);
  EXPECT_EQ(map.evicted(), 1u);
  EXPECT_EQ(map.landmark(shared[0]).observations, 2);
}

TEST(LandmarkMap, SealedKeyframesAreTakenOnceInTheirOrder) {
  LandmarkMap map(3, 10, 5);
  for (const std::size_t slot : {2, 0}) {
    map.keyframe(slot).used = true;
    map.seal(slot);
  }
  EXPECT_EQ(map.take_sealed(), &map.keyframe(2));
  EXPECT_EQ(map.take_sealed(), &map.keyframe(0));
  EXPECT_EQ(map.take_sealed(), nullptr);
}

TEST(LandmarkMap, WhatWasNotTakenIsEvictedLast) {
  LandmarkMap map(3, 100, 50);
  see(map, 0, {});  // the fewest of its own, but nobody took it
  map.seal(0);
  see(map, 1, add(map, 20));
  see(map, 2, add(map, 30));
  const std::array<std::size_t, 1> keep{2};
  EXPECT_EQ(map.take_keyframe_slot(keep), 1u);
  EXPECT_EQ(map.evicted_untaken(), 0u);
  map.keyframe(1).used = true;
  map.keyframe(1).sealed = false;
  EXPECT_EQ(map.take_keyframe_slot(keep), 0u) << "nothing else is left";
  EXPECT_EQ(map.evicted_untaken(), 1u);
  EXPECT_EQ(map.take_sealed(), nullptr) << "the slot is another keyframe's now";
}

// A window of open keyframes, a reference behind it, and one more: the least that a pool can do with.
TEST(LandmarkMap, TheSmallestPoolHasASlotForTheNextKeyframe) {
  LandmarkMap map(kMinKeyframes, 100, 10);
  for (std::size_t slot = 0; slot < kMinKeyframes; ++slot) {
    map.keyframe(slot).used = true;
    if (slot < 2) map.seal(slot);
  }
  const std::array<std::size_t, 1> reference{0};
  EXPECT_EQ(map.take_keyframe_slot(reference), 1u);
}

TEST(LandmarkMap, ALandmarkThatNobodySeesIsFreeAgain) {
  LandmarkMap map(2, 4, 4);
  see(map, 0, add(map, 4));
  EXPECT_EQ(map.add_landmark(), -1);
  map.unlink(map.keyframe(0), 2);
  EXPECT_GE(map.add_landmark(), 0);
}

TEST(LandmarkMap, MakeRoomEvictsUntilThereIsEnough) {
  LandmarkMap map(4, 40, 20);
  see(map, 0, add(map, 20));
  see(map, 1, add(map, 20));
  const std::array<std::size_t, 1> keep{1};
  map.make_room(10, keep);
  EXPECT_TRUE(map.keyframe(1).used);
  EXPECT_FALSE(map.keyframe(0).used);
  EXPECT_GE(map.add_landmark(), 0);
}

TEST(LandmarkMap, CovisibleKeyframesComeMostSharedFirst) {
  LandmarkMap map(4, 100, 50);
  const auto ids = add(map, 30);
  see(map, 0, {ids.begin(), ids.begin() + 10});
  see(map, 1, {ids.begin(), ids.begin() + 30});
  see(map, 2, {ids.begin(), ids.begin() + 20});
  see(map, 3, {ids.begin(), ids.begin() + 3});
  const std::uint32_t mark = map.next_mark();
  for (const std::int32_t id : ids) map.landmark(id).mark = mark;
  std::array<std::size_t, 8> out{};
  ASSERT_EQ(map.covisible(mark, 5, out), 3u);
  EXPECT_EQ(out[0], 1u);
  EXPECT_EQ(out[1], 2u);
  EXPECT_EQ(out[2], 0u);
}

struct SearchScene {
  explicit SearchScene(const hal::Intrinsics& camera = {}) : k(camera), map(2, 100, 100), search(k, 100) {
    frame.reserve(100);
    for (int i = 0; i < 50; ++i) {
      const double u = 40 + 11.0 * i, v = 50 + 7.0 * i, z = 2;
      Keypoint keypoint;
      keypoint.x_px = static_cast<float>(u);
      keypoint.y_px = static_cast<float>(v);
      Descriptor descriptor;
      descriptor.v[static_cast<std::size_t>(i)] = 127;
      frame.set.keypoints.push_back(keypoint);
      frame.set.descriptors.push_back(descriptor);
      frame.ray.emplace_back((u - k.cx) / k.fx, (v - k.cy) / k.fy);
      frame.point.emplace_back(frame.ray.back().x() * z, frame.ray.back().y() * z, z);
      frame.landmark.push_back(-1);
      ids.push_back(map.add_landmark());
      Landmark& l = map.landmark(ids.back());
      l.p_robot = frame.point.back();
      l.descriptor = descriptor;
      l.used = true;
    }
    search.index(frame);
  }
  hal::Intrinsics k;
  LandmarkMap map;
  GuidedSearch search;
  FeatureFrame frame;
  std::vector<std::int32_t> ids;
};

TEST(GuidedSearch, FindsEachLandmarkWhereItShouldBe) {
  SearchScene s;
  EXPECT_EQ(s.search.find(s.map, s.ids, Pose{}, {}, s.frame), 50);
  for (std::size_t i = 0; i < 50; ++i) EXPECT_EQ(s.frame.landmark[i], s.ids[i]);
}

TEST(GuidedSearch, LooksNoFartherThanItsRadiusNorBehindTheSurface) {
  SearchScene far;
  EXPECT_EQ(far.search.find(far.map, far.ids, {Matrix3d::Identity(), {0.2, 0, 0}}, {}, far.frame), 0) << "52 px away";
  SearchScene deep;
  for (Vector3d& p : deep.frame.point) p *= 0.5;
  EXPECT_EQ(deep.search.find(deep.map, deep.ids, Pose{}, {}, deep.frame), 0);
}

// The image ends where the camera says, wherever its principal point is.
TEST(GuidedSearch, LooksInTheWholeImageAndNotBesideIt) {
  hal::Intrinsics off_centre;
  off_centre.cx = 200;
  off_centre.cy = 100;
  SearchScene s(off_centre);
  EXPECT_EQ(s.search.find(s.map, s.ids, Pose{}, {}, s.frame), 50);
  hal::Intrinsics small;
  small.width = 300;
  small.height = 200;
  SearchScene t(small);
  const int inside = static_cast<int>(std::count_if(t.frame.set.keypoints.begin(), t.frame.set.keypoints.end(),
                                                    [](const Keypoint& p) { return p.x_px < 300 && p.y_px < 200; }));
  EXPECT_EQ(t.search.find(t.map, t.ids, Pose{}, {}, t.frame), inside);
}

TEST(GuidedSearch, OtherDescriptorsDoNotMatch) {
  SearchScene s;
  for (Descriptor& d : s.frame.set.descriptors) d.v.fill(20);
  EXPECT_EQ(s.search.find(s.map, s.ids, Pose{}, {}, s.frame), 0);
}

}  // namespace
}  // namespace onemap::mapping
