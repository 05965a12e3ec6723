#include "mapping/team/submap_log.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mapping/team/map_fusion.hpp"
#include "support/team_author.hpp"

namespace onemap::mapping {
namespace {

using test::Author;
using testing::ElementsAre;
using testing::IsEmpty;

std::vector<std::size_t> counting(const SubmapLog& log, std::size_t extent) {
  std::vector<std::size_t> out;
  log.for_each_of(extent, [&](const SubmapPlace& place) { out.push_back(place.position); });
  return out;
}

// Four records, of which the third replaces the first.
struct SubmapLogTest : testing::Test {
  SubmapLogTest() {
    author.submap({0, 0, 0});
    author.submap({1, 0, 0});
    author.replacing(0).submap({2, 0, 0});
    author.submap({3, 0, 0});
  }
  SubmapLog of(const std::vector<RecordPtr>& records) const {
    SubmapLog log;
    for (const RecordPtr& record : records) EXPECT_TRUE(log.add(record).ok());
    return log;
  }
  Author author{"a"};
};

TEST_F(SubmapLogTest, AMapHasNotWhatALaterOneOfItsRecordsReplaces) {
  const SubmapLog log = of(author.written());
  EXPECT_THAT(counting(log, 2), ElementsAre(0, 1));
  EXPECT_THAT(counting(log, 3), ElementsAre(1, 2));
  EXPECT_THAT(counting(log, 4), ElementsAre(1, 2, 3));
  EXPECT_EQ(log.most_whole(), 4u);
}

TEST_F(SubmapLogTest, ABodyIsLetGoWhenNoMapNeedsIt) {
  SubmapLog log = of(author.written());
  EXPECT_THAT(log.let_go(2), IsEmpty()) << "that map has it";
  EXPECT_TRUE(log.is_whole(2));
  EXPECT_THAT(log.let_go(3), ElementsAre(author.written()[0]->id));
  EXPECT_EQ(log.find(0), nullptr);
  EXPECT_THAT(log.let_go(4), IsEmpty()) << "once";
  EXPECT_FALSE(log.is_whole(2));
  EXPECT_TRUE(log.is_whole(3));
}

TEST_F(SubmapLogTest, WithoutABodyNoMapIsMadeThatNeedsIt) {
  SubmapLog log = of({test::without_body(author.written()[0]), author.written()[1]});
  EXPECT_TRUE(log.is_whole(0));
  EXPECT_FALSE(log.is_whole(1));
  EXPECT_FALSE(log.is_whole(2));
  EXPECT_EQ(log.most_whole(), 0u);
  ASSERT_TRUE(log.add(author.written()[2]).ok());
  EXPECT_FALSE(log.is_whole(2));
  EXPECT_TRUE(log.is_whole(3));
  EXPECT_EQ(log.most_whole(), 3u);
  EXPECT_THAT(counting(log, 3), ElementsAre(1, 2));
}

// Each record has its place, whatever it is worth: the first so many are the same whoever lacks which body.
TEST_F(SubmapLogTest, WhatIsMalformedHasItsPlaceAndReplacesAsItSays) {
  Author other("b");
  other.submap();
  const auto kind = static_cast<std::uint16_t>(RecordKind::submap);
  const RecordPtr bad = other.replacing(0).write(Lane::voxels, kind, {1, 2, 3});
  const RecordPtr good = other.replacing(1).submap({1, 0, 0});
  SubmapLog with, without;
  for (SubmapLog* log : {&with, &without}) EXPECT_TRUE(log->add(other.written()[0]).ok());
  EXPECT_FALSE(with.add(bad).ok());
  EXPECT_TRUE(without.add(test::without_body(bad)).ok());
  for (SubmapLog* log : {&with, &without}) {
    EXPECT_TRUE(log->add(good).ok());
    EXPECT_THAT(counting(*log, 3), ElementsAre(2));
    EXPECT_THAT(counting(*log, 2), IsEmpty());
  }
  EXPECT_TRUE(with.is_whole(2));
  EXPECT_FALSE(without.is_whole(2));
}

TEST_F(SubmapLogTest, WhatNamesNothingEarlierReplacesNothing) {
  Author other("b");
  other.submap();
  other.replacing(1).submap({1, 0, 0});
  other.replacing(7).submap({2, 0, 0});
  const SubmapLog log = of(other.written());
  EXPECT_THAT(counting(log, 3), ElementsAre(0, 1, 2));
}

// A log that names without end what is needless holds what is needed.
TEST_F(SubmapLogTest, WhatOnlyNamesAnotherIsNotHeld) {
  author.replacing(1).write(Lane::voxels, RecordKind::submap, SubmapRecord{0, 20000, 60000, {}});
  SubmapLog log = of(author.written());
  EXPECT_EQ(log.size(), 5u) << "it has its position";
  EXPECT_EQ(log.find(4), nullptr);
  EXPECT_THAT(counting(log, 5), ElementsAre(2, 3));
  EXPECT_THAT(log.let_go(5), ElementsAre(author.written()[0]->id, author.written()[1]->id));
  EXPECT_THAT(counting(log, 5), ElementsAre(2, 3));
  for (const std::size_t position : {0u, 1u, 4u}) EXPECT_EQ(log.find(position), nullptr);
}

// Robots that hold the same records make the same map, whoever of them has let which body go.
TEST_F(SubmapLogTest, TheMapDoesNotDependOnWhoHasLetGo) {
  Author robot = test::small_robot("a");
  for (int i = 0; i < 4; ++i) robot.submap({i, 1, 0}, static_cast<std::uint8_t>(50 + i));
  robot.replacing(2).submap({0, 2, 0});
  SolutionRecord solution;
  solution.reference = robot.chain();
  solution.robots.push_back({robot.chain(), {}});
  std::vector<std::uint64_t> digests;
  for (const bool lacks_it : {false, true}) {
    TeamLog log(RobotId::from_name("self"), 1);
    for (const RecordPtr& record : robot.written()) {
      const bool replaced =
          lacks_it && record->id.log.lane == static_cast<std::uint8_t>(Lane::voxels) && record->id.seq == 2;
      ASSERT_TRUE(log.apply(replaced ? test::without_body(record) : record, Instant{}).ok());
    }
    MapFusion fusion(4u << 20);
    fusion.aim(log, {solution, everything_here(log, solution)});
    while (fusion.underway()) ASSERT_TRUE(fusion.step([] { return false; }));
    EXPECT_EQ(fusion.submaps(), 5u);
    digests.push_back(fusion.digest());
    EXPECT_EQ(holds(log, {{robot.chain(), 3, 5}}), !lacks_it);
  }
  EXPECT_EQ(digests[0], digests[1]);
}

}  // namespace
}  // namespace onemap::mapping
