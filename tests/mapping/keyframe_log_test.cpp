#include "mapping/team/keyframe_log.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mapping/team/map_fusion.hpp"
#include "mapping/team/needless_keyframes.hpp"
#include "mapping/team/way_on_map.hpp"
#include "support/team_author.hpp"

namespace onemap::mapping {
namespace {

using namespace std::chrono_literals;
using test::Author;
using testing::ElementsAre;
using testing::IsEmpty;

KeyframeRecord keyframe(std::uint32_t index) {
  KeyframeRecord out;
  out.index = out.anchor = index;
  out.time = FrameTime{} + std::chrono::seconds(index);
  out.T_robot_keyframe = test::two_metres_each(index);
  out.features.resize(3);
  return out;
}

std::vector<std::uint32_t> indices(const auto& places) {
  std::vector<std::uint32_t> out;
  for (const KeyframePlace& place : places) out.push_back(place.index);
  return out;
}

// Three keyframes, then what remains of the second.
struct KeyframeLogTest : testing::Test {
  KeyframeLogTest() {
    for (std::uint32_t i = 0; i < 3; ++i) author.write(Lane::features, RecordKind::keyframe, keyframe(i));
    author.replacing(1).write(Lane::features, RecordKind::keyframe, place_alone(keyframe(1)));
  }
  KeyframeLog of(const std::vector<RecordPtr>& records) const {
    KeyframeLog log;
    for (const RecordPtr& record : records) EXPECT_TRUE(log.add(record).ok());
    return log;
  }
  std::vector<RecordPtr> late() const {  // as who comes later gets them
    std::vector<RecordPtr> records = author.written();
    records[1] = test::without_body(records[1]);
    return records;
  }
  Author author{"a"};
};

TEST_F(KeyframeLogTest, WhatRemainsStandsWhereItsKeyframeStood) {
  KeyframeLog log = of(author.written());
  EXPECT_EQ(log.size(), 4u);
  EXPECT_THAT(indices(log.places()), ElementsAre(0, 1, 2));
  EXPECT_THAT(indices(log.chain()), ElementsAre(0, 1, 2));
  EXPECT_EQ(log.place(3), nullptr) << "it stands where its keyframe stood";
  EXPECT_EQ(log.places()[1].position, 1u);
  EXPECT_EQ(log.places()[1].T_robot_keyframe, test::two_metres_each(1));
  EXPECT_EQ(log.places()[1].time, FrameTime{} + 1s);
  EXPECT_NE(log[0], nullptr);
  EXPECT_EQ(log[1], nullptr) << "what it saw is read no more";
  EXPECT_EQ(log[3], nullptr);
  EXPECT_THAT(log.gone(), ElementsAre(1));
  EXPECT_THAT(log.let_go(), ElementsAre(author.written()[1]->id));
  EXPECT_THAT(log.let_go(), IsEmpty()) << "once";
}

TEST_F(KeyframeLogTest, WithoutTheBodyItsPlaceIsWaitedFor) {
  std::vector<RecordPtr> records = late();
  records.pop_back();
  KeyframeLog log = of(records);
  EXPECT_THAT(indices(log.places()), ElementsAre(0, 2));
  EXPECT_TRUE(log.is_whole(1));
  EXPECT_FALSE(log.is_whole(2));
  EXPECT_EQ(log.most_whole(), 1u);
  ASSERT_TRUE(log.add(late().back()).ok());
  EXPECT_TRUE(log.is_whole(4));
  EXPECT_EQ(log.most_whole(), 4u);
  EXPECT_THAT(log.let_go(), IsEmpty()) << "there was nothing to let go";
  const KeyframeLog whole = of(author.written());
  EXPECT_EQ(indices(log.places()), indices(whole.places()));
  for (std::size_t i = 0; i < 3; ++i) {
    ASSERT_NE(log.place(i), nullptr);
    EXPECT_EQ(log.place(i)->T_robot_keyframe, whole.place(i)->T_robot_keyframe);
    EXPECT_EQ(log.place(i)->gone, i == 1);
  }
}

TEST_F(KeyframeLogTest, ARobotWithoutTheBodiesMakesTheSameMap) {
  author.hello();
  author.submap({0, 0, 0}, 9, 1);
  const RobotId reader = RobotId::from_name("b");
  TeamLog whole(reader, 1), lacking(reader, 1), waiting(reader, 1);
  std::vector<RecordPtr> records = late();
  for (const RecordPtr& record : author.written()) ASSERT_TRUE(whole.apply(record, {}).ok());
  for (const RecordPtr& record : records) ASSERT_TRUE(lacking.apply(record, {}).ok());
  records.erase(records.begin() + 3);
  for (const RecordPtr& record : records) ASSERT_TRUE(waiting.apply(record, {}).ok());
  const ChainId chain{author.id(), 1};
  SolutionRecord solution;
  solution.robots.push_back({chain, {{0, {}}}});
  const std::vector<ChainExtent> extents = everything_here(whole, solution);
  EXPECT_EQ(extents.at(0).keyframes, 4u);
  EXPECT_TRUE(holds(lacking, extents));
  EXPECT_FALSE(holds(waiting, extents));
  EXPECT_FALSE(holds(waiting, {{chain, 2, 0}})) << "the anchor's place is not known";
  const auto on_map = [&](const TeamLog& log) { return keyframes_on_map(*log.find(chain), solution.robots[0]); };
  ASSERT_EQ(on_map(lacking).size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(on_map(lacking)[i].T_map_keyframe, on_map(whole)[i].T_map_keyframe);
}

TEST_F(KeyframeLogTest, APlaceOfItsOwnIsAKeyframe) {
  const KeyframeLog log = of({author.written()[0], author.written()[3]});
  EXPECT_THAT(indices(log.places()), ElementsAre(0, 1)) << "what it replaces is not here: another life's log";
}

TEST_F(KeyframeLogTest, MalformedOnesHaveTheirPositions) {
  KeyframeLog log;
  const auto bad = author.write(Lane::features, static_cast<std::uint16_t>(RecordKind::keyframe), {1, 2, 3});
  EXPECT_FALSE(log.add(bad).ok());
  EXPECT_EQ(log.size(), 1u);
  EXPECT_TRUE(log.is_whole(1)) << "nothing better comes";
  EXPECT_THAT(log.chain(), IsEmpty());
  // Who has the head alone cannot tell that it was malformed.
  const auto place =
      author.replacing(bad->id.seq).write(Lane::features, RecordKind::keyframe, place_alone(keyframe(7)));
  KeyframeLog late;
  ASSERT_TRUE(late.add(test::without_body(bad)).ok());
  for (KeyframeLog* each : {&log, &late}) {
    ASSERT_TRUE(each->add(place).ok());
    ASSERT_NE(each->place(0), nullptr);
    EXPECT_EQ(each->place(0)->index, 7u);
    EXPECT_EQ(each->place(1), nullptr);
  }
}

}  // namespace
}  // namespace onemap::mapping
