#include "mapping/team/map_fusion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/team_author.hpp"

namespace onemap::mapping {
namespace {

using test::Author;

bool never() { return false; }

SolutionRecord of(const std::vector<RobotId>& robots) {
  SolutionRecord out{robots[0], {}, 0, 0};
  for (const RobotId& robot : robots) out.robots.push_back({robot, 1, {}});
  return out;
}

struct MapFusionTest : testing::Test {
  TeamLog log{RobotId::from_name("self"), 1};
  AtlasConfig config;
  MapFusionTest() { config.map.budget_bytes = 4u << 20; }
  void take(const Author& author) {
    for (const auto& record : author.written()) ASSERT_TRUE(log.apply(record, Instant{}).ok());
  }
  void fuse(MapFusion& fusion, const SolutionRecord& solution) {
    fusion.begin(solution);
    while (fusion.underway()) ASSERT_TRUE(fusion.add(*log.find(fusion.next()), never));
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
  MapFusion fusion(config);
  EXPECT_FALSE(fusion.complete(log));
  EXPECT_EQ(fusion.map(), nullptr);
  fuse(fusion, of({a.id(), b.id()}));
  EXPECT_EQ(fusion.submaps(), 2u);
  EXPECT_TRUE(fusion.complete(log));
  ASSERT_NE(fusion.map(), nullptr);
  EXPECT_GT(fusion.map()->used(), 0u);
  a.submap({5, 5, 5});
  ASSERT_TRUE(log.apply(a.written().back(), Instant{}).ok());
  EXPECT_FALSE(fusion.complete(log)) << "more of a came";
  EXPECT_FALSE(fusion.outdated(log));
  take(test::small_robot("b", 2));
  EXPECT_TRUE(fusion.outdated(log)) << "b began a new life";
}

TEST_F(MapFusionTest, DoesNothingByHalvesWhenStopped) {
  Author a = test::small_robot("a");
  for (int i = 1; i < 5; ++i) a.submap({i, 0, 0});
  take(a);
  MapFusion fusion(config), undisturbed(config);
  fusion.begin(of({a.id()}));
  int asked = 0;
  EXPECT_FALSE(fusion.add(*log.find(a.id()), [&] { return ++asked == 3; }));
  EXPECT_TRUE(fusion.underway());
  ASSERT_TRUE(fusion.add(*log.find(a.id()), never));
  fuse(undisturbed, of({a.id()}));
  EXPECT_EQ(fusion.digest(), undisturbed.digest());
}

// One robot's records may decode to gigabytes: no more is decoded than the global map's own budget; the newest count.
TEST_F(MapFusionTest, DecodesNoMoreThanItsBudget) {
  Author bomb("a");
  bomb.hello();
  for (int i = 0; i < 40; ++i) bomb.write(Lane::voxels, RecordKind::submap, large(i));
  take(bomb);
  const std::size_t most = config.map.budget_bytes / sizeof(SubmapBlock);
  MapFusion fusion(config);
  fuse(fusion, of({bomb.id()}));
  EXPECT_EQ(fusion.submaps_left_out(), 40 - most / 512);
  EXPECT_TRUE(fusion.complete(log)) << "what is left out is not waited for";
}

TEST_F(MapFusionTest, ABlockThatIsPublishedAgainCostsNothingMore) {
  Author author("a");
  author.hello();
  for (int i = 0; i < 30; ++i) author.write(Lane::voxels, RecordKind::submap, large(0));
  take(author);
  config.map.budget_bytes = 1024 * sizeof(SubmapBlock);
  MapFusion fusion(config);
  fuse(fusion, of({author.id()}));
  EXPECT_EQ(fusion.submaps_left_out(), 0u);
}

TEST_F(MapFusionTest, TellsWhichRecordsAreMalformedInside) {
  Author a = test::small_robot("a");
  SubmapRecord broken{0, 20000, 60000, {{{1, 2, 3}, {}}}};
  broken.blocks[0].voxels[7] = {2 * kTsdfOne, 1, {}};
  const RecordPtr record = a.write(Lane::voxels, RecordKind::submap, broken);
  take(a);
  MapFusion fusion(config);
  fuse(fusion, of({a.id()}));
  const auto malformed = fusion.take_malformed();
  ASSERT_EQ(malformed.size(), 1u);
  EXPECT_EQ(malformed[0].id, record->id);
  EXPECT_THAT(malformed[0].reason, testing::HasSubstr("blocks.voxels"));
  EXPECT_GT(fusion.map()->used(), 0u) << "the others went in";
  EXPECT_TRUE(fusion.complete(log));
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
  SolutionRecord solution = of({near.id(), far.id()});
  solution.robots[1].anchors = {{0, {{2147483647, -2147483647, 2147483647}}}};
  MapFusion fusion(config);
  fuse(fusion, solution);
  EXPECT_LE(fusion.map()->used(), fusion.map()->capacity());
  EXPECT_GT(fusion.map()->used(), 64u);
}

}  // namespace
}  // namespace onemap::mapping
