#include "mapping/team/loop_finder.hpp"

#include <gtest/gtest.h>

#include "support/team_robots.hpp"

namespace onemap::mapping {
namespace {

using namespace std::chrono_literals;
using test::Author;
using test::kNow;

bool never() { return false; }

std::vector<KeyframeRecord> keyframes_of(const Author& author) {
  std::vector<KeyframeRecord> out;
  for (const RecordPtr& record : author.written())
    if (record->kind == static_cast<std::uint16_t>(RecordKind::keyframe)) out.push_back(*decode_keyframe(record->body));
  return out;
}

// A robot that sees a living room, then for long a storage room, then the living room as at first. Each stay is one
// anchor.
struct LoopFinderTest : testing::Test {
  Author robot{"self"};
  TeamLog log{robot.id(), 1};
  Presence presence{robot.id(), 100s};
  OwnPlaces places{{}};
  LoopFinder finder{{}, 10s};
  std::vector<RecordPtr> records;
  std::uint32_t stay = 0;  // keyframes of the first one

  void see(const KeyframeRecord& keyframe, std::uint32_t anchor) {
    KeyframeRecord mine = keyframe;
    mine.index = static_cast<std::uint32_t>(records.size());
    mine.anchor = anchor;
    records.push_back(robot.write(Lane::features, RecordKind::keyframe, mine));
  }
  void SetUp() override {
    const auto room = keyframes_of(test::first()), storage = keyframes_of(test::stranger());
    stay = static_cast<std::uint32_t>(room.size());
    for (const KeyframeRecord& keyframe : room) see(keyframe, 0);
    for (std::size_t i = 0; i < 24; ++i) see(storage[i % storage.size()], stay);
    for (const KeyframeRecord& keyframe : room) see(keyframe, stay + 24);
    take(robot.hello());
  }
  void take(const RecordPtr& record) { ASSERT_TRUE(log.apply(record, kNow).ok()); }
  Agreement team() { return {log, presence, kNow}; }
  void end() {
    take(robot.write(Lane::control, RecordKind::finished,
                     FinishedRecord{0, 0, static_cast<std::uint32_t>(records.size()), 0}));
  }
  // What it says at the end when everything is here at once.
  LinkRecord at_once() {
    for (const RecordPtr& record : records) take(record);
    end();
    while (finder.look(team(), places, never)) {
    }
    return finder.news(team(), kNow).value_or(LinkRecord{});
  }
};

LinkPair loop_at(std::uint32_t later, std::uint32_t inliers = 50) { return {later / 2, later, inliers, {}}; }

TEST(LeastMissed, IsTheOneAmidOthersAndOfEqualOnesTheWeakest) {
  const std::vector<LinkPair> crowded{loop_at(1000), loop_at(2000), loop_at(2010), loop_at(2020), loop_at(4000)};
  EXPECT_EQ(least_missed(crowded), 2u);
  const std::vector<LinkPair> equal{loop_at(30), loop_at(2000, 60), loop_at(2000, 50), loop_at(2000, 70),
                                    loop_at(4000)};
  EXPECT_EQ(least_missed(equal), 2u);
  const std::vector<LinkPair> of_late{loop_at(1000), loop_at(1060), loop_at(1120), loop_at(3980), loop_at(4000)};
  EXPECT_EQ(least_missed(of_late), 1u) << "where the robot is now it is held by more";
  EXPECT_EQ(least_missed(std::vector{loop_at(7)}), 0u);
}

// A robot that comes back all the time, for long: its whole way is held, the newest part by more.
TEST(LeastMissed, LeavesTheWholeWayHeld) {
  constexpr std::uint32_t kEnd = 12'000;
  std::vector<LinkPair> kept;
  for (std::uint32_t later = 21; later < kEnd; ++later) {
    kept.push_back(loop_at(later));
    if (kept.size() > kMaxLinkPairs) kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(least_missed(kept)));
  }
  ASSERT_EQ(kept.size(), kMaxLinkPairs);
  EXPECT_GT(kept.back().keyframe_b, kEnd - 5);
  EXPECT_LT(kept.front().keyframe_b, 100u);
  for (std::size_t i = 1; i < kept.size(); ++i) {
    const std::uint32_t gap = kept[i].keyframe_b - kept[i - 1].keyframe_b, ago = kEnd - kept[i - 1].keyframe_b;
    EXPECT_LT(gap, ago < kEnd / 64 ? 20u : 2 * kEnd / kMaxLinkPairs) << kept[i].keyframe_b;
  }
}

TEST_F(LoopFinderTest, FindsWhereTheRobotCameBack) {
  const LinkRecord loops = at_once();
  EXPECT_EQ(loops.a, robot.id());
  EXPECT_EQ(loops.b, robot.id());
  EXPECT_EQ(loops.keyframes_a, records.size());
  ASSERT_EQ(loops.reason, LinkReason::accepted);
  ASSERT_GE(loops.pairs.size(), 2u);
  EXPECT_LE(loops.pairs.size(), 3u) << "more of one pair of anchors say nothing new";
  for (const LinkPair& pair : loops.pairs) {
    EXPECT_LT(pair.keyframe_a, stay);
    EXPECT_GE(pair.keyframe_b, stay + 24);
    const bool same_view = pair.keyframe_a + stay + 24 == pair.keyframe_b;
    EXPECT_LT(from_quantized(pair.T_a_b).t.norm(), same_view ? 0.01 : 1);
  }
  EXPECT_TRUE(decode_link(encode(loops)).ok());
  EXPECT_FALSE(finder.news(team(), kNow)) << "told once";
}

TEST_F(LoopFinderTest, NeighboursAreNoLoops) {
  Author walker("self");
  TeamLog near(walker.id(), 1);
  ASSERT_TRUE(near.apply(walker.hello(), kNow).ok());
  for (std::uint32_t i = 0; i < 2 * stay; ++i) {
    KeyframeRecord keyframe = *decode_keyframe(records[i % stay]->body);
    keyframe.index = i;
    keyframe.anchor = i < stay ? 0 : stay;
    ASSERT_TRUE(near.apply(walker.write(Lane::features, RecordKind::keyframe, keyframe), kNow).ok());
  }
  const Agreement alone(near, presence, kNow);
  while (finder.look(alone, places, never)) {
  }
  EXPECT_FALSE(finder.news(alone, kNow)) << "odometry joins them anyway";
}

TEST_F(LoopFinderTest, WhenTheKeyframesComeDoesNotMatter) {
  const LinkRecord expected = at_once();
  TeamLog slow(robot.id(), 1);
  OwnPlaces their_places{{}};
  LoopFinder other({}, 10s);
  ASSERT_TRUE(slow.apply(robot.written().back(), kNow).ok());
  LinkRecord last;
  Instant now = kNow;
  for (const RecordPtr& record : robot.written()) {
    ASSERT_TRUE(slow.apply(record, kNow).ok());
    const Agreement team(slow, presence, now += 4s);
    while (other.look(team, their_places, never)) {
    }
    if (const auto news = other.news(team, now)) last = *news;
  }
  EXPECT_EQ(encode(last), encode(expected));
}

TEST_F(LoopFinderTest, WhileMappingItTellsWhatIsNewNowAndThen) {
  for (const RecordPtr& record : records) take(record);
  while (finder.look(team(), places, never)) {
  }
  const auto first = finder.news(team(), kNow);
  ASSERT_TRUE(first.has_value());
  EXPECT_FALSE(first->pairs.empty());
  EXPECT_FALSE(finder.news(team(), kNow + 20s)) << "nothing new was found";
  end();
  EXPECT_FALSE(finder.news(team(), kNow + 20s)) << "and that was all of it";
}

TEST_F(LoopFinderTest, StoppedItLooksAtThatKeyframeAgain) {
  const LinkRecord expected = at_once();
  LoopFinder other({}, 10s);
  int stopped = 0;
  const auto stop = [&] { return ++stopped > 0; };
  do {
    while (other.look(team(), places, stop)) {
    }
  } while (other.look(team(), places, never));
  EXPECT_GE(stopped, 3);
  EXPECT_EQ(encode(other.news(team(), kNow).value_or(LinkRecord{})), encode(expected));
}

TEST_F(LoopFinderTest, AnotherLifeBeginsAnew) {
  at_once();
  log.begin_life(7, true);
  Author again("self", 7);
  take(again.hello());
  take(again.write(Lane::features, RecordKind::keyframe, *decode_keyframe(records[0]->body)));
  take(again.write(Lane::control, RecordKind::finished, FinishedRecord{0, 0, 1, 0}));
  EXPECT_TRUE(finder.look(team(), places, never));
  const auto news = finder.news(team(), kNow);
  ASSERT_TRUE(news.has_value());
  EXPECT_EQ(news->incarnation_other, 7u);
  EXPECT_EQ(news->keyframes_a, 1u);
  EXPECT_TRUE(news->pairs.empty());
}

}  // namespace
}  // namespace onemap::mapping
