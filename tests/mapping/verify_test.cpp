#include "mapping/team/verify.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mapping/team/needless_keyframes.hpp"
#include "support/explorer.hpp"
#include "support/poses.hpp"
#include "team/verify_clouds.hpp"

namespace onemap::mapping {
namespace {

using test::explore;
using test::Explorer;

// One pair of keyframes as the verifier looks at it.
PairResult closely(const KeyframeRecord& r, const KeyframeRecord& s) {
  return verify_clouds(unpack(r), unpack(s), VerifyConfig{}).result;
}

const RobotId kA = RobotId::from_name("a"), kB = RobotId::from_name("b");

TEST(VerifyRobots, TwoRobotsInOneRoomAreRelatedAsTheyAre) {
  const Explorer a = explore("simulated:living-room?robot=1&frames=100"),
                 b = explore("simulated:living-room?robot=2&frames=100");
  for (const FindPairs mode : {FindPairs::by_index, FindPairs::all_pairs}) {
    VerifyConfig config;
    config.find_pairs = mode;
    const LinkRecord link = verify_robots(kA, a.keyframes, kB, b.keyframes, config);
    ASSERT_EQ(link.reason, LinkReason::accepted);
    EXPECT_GE(link.supporting_pairs, 2u);
    const Pose truth = a.T_world_first.inverse() * b.T_world_first, off = truth.inverse() * from_quantized(link.T_a_b);
    EXPECT_LT(off.t.norm(), 0.04);
    EXPECT_LT(test::rotation_angle(off.R), 0.02);
  }
}

// Keyframes of which the places alone are left lie beside others, too, and show nothing.
TEST(VerifyRobots, WhatIsAPlaceAloneSpeaksAgainstNothing) {
  const std::string living_room = "simulated:living-room?frames=100&robot=";
  Explorer a = explore(living_room + "1"), b = explore(living_room + "2");
  for (Explorer* robot : {&a, &b})
    for (std::size_t i = 0; i < robot->keyframes.size(); ++i)
      if (i % 3 != 0) robot->keyframes[i] = place_alone(robot->keyframes[i]);
  const LinkRecord link = verify_robots(kA, a.keyframes, kB, b.keyframes, {});
  EXPECT_EQ(link.reason, LinkReason::accepted);
  EXPECT_GE(link.supporting_pairs, 2u);
}

TEST(VerifyRobots, OrbLinksThemToo) {
  const std::string living_room = "simulated:living-room?frames=100&robot=";
  const Explorer a = explore(living_room + "1", DescriptorKind::orb),
                 b = explore(living_room + "2", DescriptorKind::orb);
  ASSERT_EQ(a.keyframes[0].descriptor_kind, DescriptorKind::orb);
  const LinkRecord link = verify_robots(kA, a.keyframes, kB, b.keyframes, {});
  ASSERT_EQ(link.reason, LinkReason::accepted);
  const Pose truth = a.T_world_first.inverse() * b.T_world_first, off = truth.inverse() * from_quantized(link.T_a_b);
  EXPECT_LT(off.t.norm(), 0.06);
}

// Each robot chooses its kind of features; unlike kinds cannot be compared, and nothing else breaks.
TEST(VerifyRobots, UnlikeKindsOfFeaturesAreNoLink) {
  const std::string room = "simulated:living-room?frames=20&robot=1";
  const Explorer a = explore(room), b = explore(room, DescriptorKind::orb);
  for (const FindPairs mode : {FindPairs::by_index, FindPairs::all_pairs}) {
    VerifyConfig config;
    config.find_pairs = mode;
    EXPECT_EQ(verify_robots(kA, a.keyframes, kB, b.keyframes, config).reason, LinkReason::too_few_matches);
  }
}

TEST(VerifyRobots, RobotsInDifferentPlacesAreRefusedWithAReason) {
  const Explorer a = explore("simulated:living-room?robot=1&frames=60"),
                 b = explore("simulated:storage?robot=1&frames=60");
  const LinkRecord link = verify_robots(kA, a.keyframes, kB, b.keyframes, {});
  EXPECT_NE(link.reason, LinkReason::accepted);
}

// The doors of two corridors look alike on purpose; so do their walls, floors and shapes.
TEST(VerifyRobots, LookAlikeDoorsOfDifferentCorridorsAreRefused) {
  const Explorer a = explore("simulated:corridor?frames=60"), b = explore("simulated:corridor?frames=60&seed=2");
  EXPECT_NE(verify_robots(kA, a.keyframes, kB, b.keyframes, {}).reason, LinkReason::accepted);
}

// Two robots in different parts of one ring: the doors repeat, so many pairs of clouds agree that they met.
TEST(VerifyRobots, LookAlikeDoorsOfOneRingAreRefusedByWhatLiesBetweenThem) {
  const std::string ring = "simulated:ring?robots=2&frames=150&fps=10&seed=10&robot=";
  const Explorer a = explore(ring + "1"), b = explore(ring + "2");
  const LinkRecord link = verify_robots(kA, a.keyframes, kB, b.keyframes, {});
  EXPECT_THAT(link.reason, testing::AnyOf(LinkReason::another_place, LinkReason::not_seen_again));
  EXPECT_GT(link.measured, 0u);
  EXPECT_GE(link.supporting_pairs, 4u) << "or this is no hard case any more";
  EXPECT_TRUE(link.pairs.empty());
}

// The same keyframe, but of the uppermost rows of its depth grid everything is at half the distance.
KeyframeRecord with_nearer_rows(KeyframeRecord keyframe, double share) {
  std::vector<std::uint16_t>& depths = keyframe.grid.inverse_depth;
  for (std::size_t i = 0; i < static_cast<std::size_t>(share * static_cast<double>(depths.size())); ++i)
    depths[i] = static_cast<std::uint16_t>(std::min(2 * depths[i], 0xffff));
  return keyframe;
}

// Matching features are not enough: here the second cloud's depth says that the first looked through a wall.
TEST(VerifyClouds, ConflictWithSpaceSeenFreeIsRefused) {
  const KeyframeRecord a = explore("simulated:living-room?robot=1&frames=5").keyframes[0];
  EXPECT_EQ(closely(a, a).reason, LinkReason::accepted);
  const PairResult through = closely(a, with_nearer_rows(a, 0.4));
  EXPECT_EQ(through.reason, LinkReason::seen_through);
  EXPECT_NEAR(through.measured, 6000, 700) << "of 10000 are where the other saw them";
}

TEST(VerifyClouds, CloudsThatHardlyOverlapAreRefused) {
  const KeyframeRecord a = explore("simulated:living-room?robot=1&frames=5").keyframes[0];
  const PairResult apart = closely(a, with_nearer_rows(a, 0.85));
  EXPECT_EQ(apart.reason, LinkReason::little_overlap);
  EXPECT_LT(apart.measured, 2500u);
}

TEST(VerifyRobots, SameInputGivesTheSameBytes) {
  const Explorer a = explore("simulated:office?robot=1&frames=50"), b = explore("simulated:office?robot=2&frames=50");
  EXPECT_EQ(encode(verify_robots(kA, a.keyframes, kB, b.keyframes, {})),
            encode(verify_robots(kA, a.keyframes, kB, b.keyframes, {})));
}

TEST(VerifyClouds, AKeyframeMatchesItself) {
  const Explorer a = explore("simulated:living-room?robot=1&frames=10");
  const PairResult r = closely(a.keyframes[0], a.keyframes[0]);
  EXPECT_EQ(r.reason, LinkReason::accepted);
  EXPECT_LT(r.T_r_s.t.norm(), 1e-3);
  EXPECT_GT(r.ratio, 0.9);
}

TEST(VerifyClouds, NothingInCommonIsTooFewMatches) {
  const Explorer a = explore("simulated:living-room?robot=1&frames=5");
  KeyframeRecord empty = a.keyframes[0];
  empty.features.clear();
  EXPECT_EQ(closely(a.keyframes[0], empty).reason, LinkReason::too_few_matches);
}

}  // namespace
}  // namespace onemap::mapping
