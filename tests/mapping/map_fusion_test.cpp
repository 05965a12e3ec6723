#include "mapping/team/map_fusion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/team_author.hpp"

namespace onemap::mapping {
namespace {

using test::Author;

bool never_stop() { return false; }

SolutionRecord of(const std::vector<ChainId>& chains) {
  SolutionRecord out;
  out.reference = chains[0];
  for (const ChainId& chain : chains) out.robots.push_back({chain, {}});
  return out;
}

struct MapFusionTest : testing::Test {
  TeamLog log{RobotId::from_name("self"), 1};
  std::size_t budget_bytes = 4u << 20;
  void take(const Author& author) {
    for (const auto& record : author.written()) ASSERT_TRUE(log.apply(record, Instant{}).ok());
  }
  MapTarget all(const SolutionRecord& solution) const { return {solution, everything_here(log, solution)}; }
  void finish(MapFusion& fusion) const {
    while (fusion.underway()) ASSERT_TRUE(fusion.step(never_stop));
  }
  void fuse(MapFusion& fusion, const SolutionRecord& solution) const {
    fusion.aim(log, all(solution));
    finish(fusion);
  }
  std::uint64_t fresh(const MapTarget& target) const {
    MapFusion fusion(budget_bytes);
    fusion.aim(log, target);
    finish(fusion);
    return fusion.digest();
  }
};

// Takes 1.5 MB when it is decoded, and a kilobyte as a record. 512 blocks around (8 * number, 0, 0).
SubmapRecord large(int number) {
  SubmapRecord record{0, 20000, 60000, {}};
  for (int i = 0; i < 512; ++i) {
    record.blocks.push_back({{8 * number + i / 64, i / 8 % 8, i % 8}, {}});
    record.blocks.back().voxels[0].weight = 1;
  }
  return record;
}

TEST_F(MapFusionTest, KnowsWhatWentIn) {
  Author a = test::small_robot("a"), b = test::small_robot("b");
  take(a);
  take(b);
  const SolutionRecord solution = of({a.chain(), b.chain()});
  MapFusion fusion(budget_bytes);
  EXPECT_FALSE(fusion.done());
  EXPECT_EQ(fusion.map(), nullptr);
  fuse(fusion, solution);
  EXPECT_EQ(fusion.submaps(), 2u);
  EXPECT_TRUE(fusion.at(all(solution)));
  ASSERT_NE(fusion.map(), nullptr);
  EXPECT_GT(fusion.map()->used(), 0u);
  const MapTarget before = all(solution);
  a.submap({5, 5, 5});
  ASSERT_TRUE(log.apply(a.written().back(), Instant{}).ok());
  EXPECT_FALSE(fusion.at(all(solution))) << "more of a came";
  EXPECT_TRUE(fusion.at(before)) << "and the map is still what it was";
}

// By whatever detours: the map of a target is one.
TEST_F(MapFusionTest, TheMapIsAFunctionOfItsTarget) {
  Author a = test::small_robot("a"), b = test::small_robot("b");
  for (int i = 1; i < 6; ++i) {
    a.submap({i, 0, 0});
    b.submap({i % 3, i % 2, 0}, static_cast<std::uint8_t>(20 * i));
  }
  take(a);
  take(b);
  const SolutionRecord solution = of({a.chain(), b.chain()});
  SolutionRecord bent = solution;
  bent.robots[1].anchors = {{0, {{1234, 777, 4321}}}};
  std::vector<MapTarget> targets;
  for (const SolutionRecord& s : {solution, bent})
    for (const std::uint32_t n : {1u, 3u, 6u}) targets.push_back({s, {{a.chain(), 3, n}, {b.chain(), 3, 7 - n}}});
  MapFusion fusion(budget_bytes);
  for (const std::size_t next : {0u, 2u, 1u, 5u, 3u, 0u, 4u, 4u, 2u}) {
    fusion.aim(log, targets[next]);
    finish(fusion);
    EXPECT_TRUE(fusion.at(targets[next]));
    EXPECT_EQ(fusion.digest(), fresh(targets[next])) << next;
  }
}

TEST_F(MapFusionTest, OnlyWhatChangedIsFusedAgain) {
  Author a = test::small_robot("a"), b = test::small_robot("b");
  take(a);
  take(b);
  const SolutionRecord solution = of({a.chain(), b.chain()});
  MapFusion fusion(budget_bytes);
  fuse(fusion, solution);
  EXPECT_EQ(fusion.submaps_fused(), 2u);
  a.submap({5, 5, 5});
  ASSERT_TRUE(log.apply(a.written().back(), Instant{}).ok());
  fuse(fusion, solution);
  EXPECT_EQ(fusion.submaps_fused(), 3u);
  fuse(fusion, solution);
  EXPECT_EQ(fusion.submaps_fused(), 3u);
}

// Which blocks find no room follows from the target, not from what was there before.
TEST_F(MapFusionTest, AFullMapIsTheSameByAnyWay) {
  budget_bytes = 200u << 10;
  Author a("a"), b("b");
  for (Author* author : {&a, &b}) {
    author->hello();
    author->keyframe();
  }
  for (int i = 0; i < 20; ++i) {
    a.submap({i, 0, 0});
    b.submap({19 - i, 1, 0});  // what the small one has, the full one would have no room for
  }
  take(a);
  take(b);
  const SolutionRecord solution = of({a.chain(), b.chain()});
  const MapTarget full{solution, {{a.chain(), 1, 20}, {b.chain(), 1, 20}}}, small{solution, {{b.chain(), 1, 3}}};
  MapFusion fusion(budget_bytes);
  for (const MapTarget* target : {&small, &full, &small, &full}) {
    fusion.aim(log, *target);
    finish(fusion);
    EXPECT_EQ(fusion.digest(), fresh(*target));
    EXPECT_EQ(fusion.map()->counters().blocks_refused > 0, target == &full);
  }
}

TEST_F(MapFusionTest, WhatHasNoAnchorIsLeftOutAndCounted) {
  Author a = test::small_robot("a"), astray = a;
  astray.submap({9, 9, 9}, 9, 1);  // on a keyframe that is there
  KeyframeRecord last;
  last.index = last.anchor = 9;  // what hangs on 5 is before it, and on 77 behind
  astray.write(Lane::features, RecordKind::keyframe, last);
  take(astray);
  MapFusion fusion(budget_bytes);
  const SolutionRecord solution = of({a.chain()});
  fuse(fusion, solution);
  EXPECT_EQ(fusion.blocks_unplaced(), 0u);
  const std::uint64_t digest = fusion.digest();
  for (const std::uint32_t anchor : {5u, 77u})
    ASSERT_TRUE(log.apply(astray.submap({9, 9, 9}, 9, anchor), Instant{}).ok());
  fuse(fusion, solution);
  EXPECT_EQ(fusion.blocks_unplaced(), 2u);
  EXPECT_EQ(fusion.digest(), digest);
}

// The solution says what the map is like, whoever makes it.
TEST_F(MapFusionTest, ParametersAreTheSolutions) {
  Author a = test::small_robot("a");
  take(a);
  SolutionRecord coarse = of({a.chain()});
  MapFusion fusion(budget_bytes);
  fuse(fusion, coarse);
  coarse.map = {40'000, 120'000, 3};
  fuse(fusion, coarse);
  EXPECT_EQ(fusion.map()->config().voxel_um(), 40'000);
  EXPECT_EQ(fusion.map()->capacity(), 3u);
  budget_bytes *= 2;
  EXPECT_EQ(fusion.digest(), fresh(all(coarse)));
}

TEST_F(MapFusionTest, DoesNothingByHalvesWhenStopped) {
  Author a = test::small_robot("a");
  for (int i = 1; i < 5; ++i) a.submap({i, 0, 0});
  take(a);
  MapFusion fusion(budget_bytes);
  fusion.aim(log, all(of({a.chain()})));
  int asked = 0;
  EXPECT_FALSE(fusion.step([&] { return ++asked == 3; }));
  EXPECT_TRUE(fusion.underway());
  finish(fusion);
  EXPECT_EQ(fusion.digest(), fresh(all(of({a.chain()}))));
}

// One place's records may decode to gigabytes: no more is decoded than half the global map's budget; the newest count.
TEST_F(MapFusionTest, DecodesNoMoreThanItsBudget) {
  Author bomb("a");
  bomb.hello();
  bomb.keyframe();
  for (int i = 0; i < 40; ++i) bomb.write(Lane::voxels, RecordKind::submap, large(i));
  take(bomb);
  const std::size_t most = budget_bytes / 2 / sizeof(SubmapBlock);
  ASSERT_GE(most, 512u);
  MapFusion fusion(budget_bytes);
  fuse(fusion, of({bomb.chain()}));
  EXPECT_EQ(fusion.submaps_left_out(), 40 - most / 512);
  EXPECT_TRUE(fusion.done()) << "what is left out is not waited for";
}

TEST_F(MapFusionTest, ABlockThatIsPublishedAgainCostsNothingMore) {
  Author author("a");
  author.hello();
  author.keyframe();
  for (int i = 0; i < 30; ++i) author.write(Lane::voxels, RecordKind::submap, large(0));
  take(author);
  budget_bytes = 2048 * sizeof(SubmapBlock);
  MapFusion fusion(budget_bytes);
  fuse(fusion, of({author.chain()}));
  EXPECT_EQ(fusion.submaps_left_out(), 0u);
}

TEST_F(MapFusionTest, TellsWhichRecordsAreMalformedInside) {
  Author a = test::small_robot("a");
  SubmapRecord broken{0, 20000, 60000, {{{1, 2, 3}, {}}}};
  broken.blocks[0].voxels[7] = {2 * kTsdfOne, 1, {}};
  const RecordPtr record = a.write(Lane::voxels, RecordKind::submap, broken);
  take(a);
  MapFusion fusion(budget_bytes);
  fuse(fusion, of({a.chain()}));
  const auto malformed = fusion.take_malformed();
  ASSERT_EQ(malformed.size(), 1u);
  EXPECT_EQ(malformed[0].id, record->id);
  EXPECT_THAT(malformed[0].reason, testing::HasSubstr("blocks.voxels"));
  EXPECT_GT(fusion.map()->used(), 0u) << "the others went in";
  EXPECT_TRUE(fusion.done());
}

// A map 21 km away with blocks at the ends of what can be said costs what any other costs.
TEST_F(MapFusionTest, FarPlacesCostNoMore) {
  Author near("a"), far("b");
  near.hello();
  far.hello();
  near.keyframe();
  far.keyframe();
  for (const int at : {-(1 << 20) + 1, 0, (1 << 20) - 1}) {
    SubmapRecord record{0, 80000, 8'000'000, {{{at, at, at}, {}}}};
    for (auto& voxel : record.blocks[0].voxels) voxel = {0, 200, {1, 1, 1}};
    far.write(Lane::voxels, RecordKind::submap, record);
  }
  near.submap();
  take(near);
  take(far);
  SolutionRecord solution = of({near.chain(), far.chain()});
  solution.robots[1].anchors = {{0, {{2147483647, -2147483647, 2147483647}}}};
  MapFusion fusion(budget_bytes);
  fuse(fusion, solution);
  EXPECT_LE(fusion.map()->used(), fusion.map()->capacity());
  EXPECT_GT(fusion.map()->used(), 64u);
}

}  // namespace
}  // namespace onemap::mapping
