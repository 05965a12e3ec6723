#include "mapping/team/own_places.hpp"

#include <gtest/gtest.h>

#include "support/team_robots.hpp"

namespace onemap::mapping {
namespace {

using test::Author;
using test::kNow;

// A robot that goes round one room for long.
struct OwnPlacesTest : testing::Test {
  Author robot{"self"};
  TeamLog log{robot.id(), 1};
  std::vector<KeyframeRecord> room;
  std::uint32_t seen = 0;

  void SetUp() override {
    ASSERT_TRUE(log.apply(robot.hello(), kNow).ok());
    for (const RecordPtr& record : test::first().written())
      if (record->kind == static_cast<std::uint16_t>(RecordKind::keyframe))
        room.push_back(*decode_keyframe(record->body));
    ASSERT_FALSE(room.empty());
  }
  void see(std::size_t keyframes) {
    for (std::size_t i = 0; i < keyframes; ++i, ++seen) {
      KeyframeRecord mine = room[seen % room.size()];
      mine.index = mine.anchor = seen;
      ASSERT_TRUE(log.apply(robot.write(Lane::features, RecordKind::keyframe, mine), kNow).ok());
    }
  }
  std::vector<std::uint32_t> found(PlaceIndex& index, const KeyframeRecord& asked) {
    std::vector<std::uint32_t> out;
    for (const Place& place : index.query(asked.descriptor_kind, binary_features(asked), 10'000))
      out.push_back(place.id.keyframe);
    return out;
  }
};

TEST_F(OwnPlacesTest, AFullIndexKeepsEveryFewthKeyframeOfTheWholeWay) {
  PlaceIndexConfig small;
  small.budget_bytes = 4u << 20;
  OwnPlaces places(small), later(small);
  see(20);
  EXPECT_EQ(places.up_to_date(robot.id(), *log.own()).keyframes(), 20u);
  EXPECT_EQ(places.left_out(), 0u);
  for (int i = 0; i < 10; ++i) {
    see(28);
    places.up_to_date(robot.id(), *log.own());
  }
  PlaceIndex& index = places.up_to_date(robot.id(), *log.own());
  EXPECT_EQ(places.left_out(), seen - index.keyframes());
  EXPECT_EQ(index.refused(), 0u);
  std::uint32_t every = 1;
  while (index.keyframes() < (seen + every - 1) / every) every *= 2;
  EXPECT_GE(every, 4u) << "the room has too few features for this test";
  EXPECT_EQ(index.keyframes(), (seen + every - 1) / every);
  std::set<std::uint32_t> all;
  for (const KeyframeRecord& asked : room)
    for (const std::uint32_t keyframe : found(index, asked)) all.insert(keyframe);
  EXPECT_EQ(all.size(), index.keyframes()) << "the first as well as the last";
  for (const std::uint32_t keyframe : all) EXPECT_EQ(keyframe % every, 0u);
  // What it holds does not depend on when it was asked.
  PlaceIndex& at_once = later.up_to_date(robot.id(), *log.own());
  EXPECT_EQ(at_once.query(room[0].descriptor_kind, binary_features(room[0]), 10'000),
            index.query(room[0].descriptor_kind, binary_features(room[0]), 10'000));
}

}  // namespace
}  // namespace onemap::mapping
