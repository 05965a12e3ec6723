// The map while robots write: the elected one says how far everybody's records count, and who holds them has its map.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/team_robots.hpp"

namespace onemap::mapping {
namespace {

using namespace std::chrono_literals;
using test::Author;
using test::kNow;
using test::link_of;
using test::Records;
using test::Robot;

std::size_t count(const Records& records, RecordKind kind) {
  return static_cast<std::size_t>(std::ranges::count_if(
      records, [&](const RecordPtr& record) { return record->kind == static_cast<std::uint16_t>(kind); }));
}

// Robots a and b, linked, that never finish.
struct TeamFrontier : testing::Test {
  Author a = test::small_robot("a"), b = test::small_robot("b");
  Records all;
  void SetUp() override {
    a.link(link_of("a", "b"));
    for (const Author* author : {&a, &b}) all.insert(all.end(), author->written().begin(), author->written().end());
  }
};

TEST_F(TeamFrontier, WhoHoldsItsRecordsHasTheDecidersMap) {
  Robot decider(a, 10s), other(b, 10s);
  for (const RecordPtr& record : all) decider.apply(record), other.apply(record);
  const Records said = decider.work(kNow + 1s);
  EXPECT_EQ(count(said, RecordKind::solution), 1u);
  EXPECT_EQ(count(said, RecordKind::frontier), 1u);
  ASSERT_NE(decider.view().digest, 0u);
  EXPECT_FALSE(decider.view().settled) << "nobody has finished";
  EXPECT_EQ(other.view().digest, 0u);
  other.apply(said);
  EXPECT_TRUE(other.work(kNow + 2s).empty()) << "it says nothing, for it does not decide";
  EXPECT_EQ(other.view().digest, decider.view().digest);
  EXPECT_EQ(other.view().digests, std::vector<std::uint64_t>{decider.view().digest});
  EXPECT_TRUE(other.view().T_map_odometry.has_value());
}

TEST_F(TeamFrontier, TheMapKeepsUpAndWaitsForWhatIsMissing) {
  Robot decider(a, 10s), other(b, 10s);
  for (const RecordPtr& record : all) decider.apply(record), other.apply(record);
  other.apply(decider.work(kNow + 1s));
  other.work(kNow + 1s);
  const std::uint64_t before = other.view().digest;
  const RecordPtr more = b.submap({5, 5, 5}, 77);
  decider.apply(more);
  const Records said = decider.work(kNow + 3s);
  EXPECT_EQ(count(said, RecordKind::solution), 0u) << "no anchor moved";
  ASSERT_EQ(count(said, RecordKind::frontier), 1u);
  EXPECT_NE(decider.view().digest, before);
  other.apply(said);
  other.work(kNow + 3s);
  EXPECT_EQ(other.view().digest, before) << "it lacks a record of the frontier";
  other.apply(more);
  other.work(kNow + 5s);
  EXPECT_EQ(other.view().digest, decider.view().digest);
}

// Records that come late, each after the next frontier was said: there would never be a moment with the newest one's.
TEST_F(TeamFrontier, WhoIsAlwaysBehindMakesTheMapThatItCan) {
  Robot decider(a, 10s), other(b, 10s);
  for (const RecordPtr& record : all) decider.apply(record), other.apply(record);
  other.apply(decider.work(kNow + 1s));
  other.work(kNow + 1s);
  RecordPtr late;
  std::vector<std::uint64_t> made{decider.view().digest};
  for (int i = 0; i < 40; ++i) {
    const Instant when = kNow + std::chrono::seconds(2 + i);
    const RecordPtr next = b.submap({5, 5, 5 + i}, 77);
    decider.apply(next);
    other.apply(decider.work(when));
    if (late != nullptr) other.apply(late);
    late = next;
    made.push_back(decider.view().digest);
    other.work(when);
    EXPECT_EQ(other.view().digest, made[made.size() - 2]) << i;
  }
}

// Of many that it lacks one that is as old as need be is still known when its records come.
TEST_F(TeamFrontier, WhoIsFarBehindStillGetsAMap) {
  Robot decider(a, 10s), other(b, 10s);
  for (const RecordPtr& record : all) decider.apply(record), other.apply(record);
  Records late;
  std::vector<std::uint64_t> made;
  for (int i = 0; i < 60; ++i) {
    const Instant when = kNow + std::chrono::seconds(1 + i);
    late.push_back(b.submap({5, 5, 5 + i}, 77));
    decider.apply(late.back());
    other.apply(decider.work(when));
    made.push_back(decider.view().digest);
    if (i < 20) continue;
    other.apply(late[static_cast<std::size_t>(i) - 20]);
    other.work(when);
  }
  const auto at = std::ranges::find(made, other.view().digest);
  ASSERT_NE(at, made.end());
  EXPECT_GE(at - made.begin(), 60 - 20 - 20) << "no older than twice what it lags";
}

TEST_F(TeamFrontier, NothingNewIsNotSaidAgain) {
  Robot decider(a, 10s);
  decider.apply(all);
  decider.work(kNow + 1s);
  EXPECT_TRUE(decider.work(kNow + 100s).empty());
}

// It lives and decides nothing, or is configured not to while robots map: after a while the next one does.
TEST_F(TeamFrontier, WhoDoesNotDecideIsPassedOver) {
  Robot other(b, 10s);
  other.apply(all);
  for (int s = 1; s <= 60; s += 10)
    EXPECT_EQ(count(other.work(kNow + std::chrono::seconds(s)), RecordKind::solution), 0u);
  other.work(kNow + 70s);
  const Records said = other.work(kNow + 71s);
  EXPECT_EQ(count(said, RecordKind::solution), 1u);
  EXPECT_NE(other.view().digest, 0u);
  EXPECT_EQ(other.events<DeciderPassedOver>().size(), 1u);
}

TEST_F(TeamFrontier, AnotherChainOfThisRobotsIsNotInTheMapYet) {
  Robot decider(a, 10s);
  decider.apply(all);
  decider.work(kNow + 1s);
  EXPECT_TRUE(decider.view().T_map_odometry.has_value());
  decider.map().begin_life(2, false);
  EXPECT_FALSE(decider.view().T_map_odometry.has_value());
  EXPECT_EQ(decider.view().chain, 1u);
}

// What an earlier life of the decider's said counts for nobody any longer: the map would stand still.
TEST_F(TeamFrontier, AnotherChainOfTheDecidersSaysTheSolutionAnew) {
  Robot alone(b, 10s);
  alone.apply(b.written());
  ASSERT_EQ(count(alone.work(kNow + 1s), RecordKind::solution), 1u);
  const std::uint64_t before = alone.view().digest;
  alone.map().begin_life(2, false);
  Author later("b", 2);
  alone.apply(later.hello());
  const Records said = alone.work(kNow + 30s);
  EXPECT_EQ(count(said, RecordKind::solution), 1u);
  EXPECT_EQ(count(said, RecordKind::frontier), 1u);
  EXPECT_EQ(alone.view().digest, before) << "nothing else is new";
}

// The decider dies without a word: the next one takes over from where it was.
TEST_F(TeamFrontier, TheNextOneTakesOver) {
  Robot decider(a, 10s), other(b, 10s);
  for (const RecordPtr& record : all) decider.apply(record), other.apply(record);
  other.apply(decider.work(kNow + 1s));
  other.work(kNow + 1s);
  const std::uint64_t before = other.view().digest;
  other.apply(b.submap({5, 5, 5}, 77));
  EXPECT_TRUE(other.work(kNow + 30s, {a.id()}).empty()) << "it is waited for";
  const Records said = other.work(kNow + 62s, {a.id()});
  EXPECT_EQ(count(said, RecordKind::solution), 1u);
  EXPECT_EQ(count(said, RecordKind::frontier), 1u);
  EXPECT_NE(other.view().digest, before);
  EXPECT_EQ(other.map().solution()->reference, a.chain()) << "and the frame stays";
}

}  // namespace
}  // namespace onemap::mapping
