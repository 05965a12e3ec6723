#include "mapping/team/pair_verifier.hpp"

#include <gtest/gtest.h>

#include "support/team_author.hpp"

namespace onemap::mapping {
namespace {

using namespace std::chrono_literals;
using test::Author;

constexpr Instant kPairStart{};
bool never() { return false; }

// Robots a, b, c whose keyframes have nothing in common, seen by b.
struct PairVerifierTest : testing::Test {
  Author a = test::small_robot("a"), b = test::small_robot("b"), c = test::small_robot("c", 7);
  TeamLog log{b.id(), 1};
  Presence presence{b.id(), 100s};
  OwnPlaces places{{}};
  PairVerifier verifier{{}, places, 0s, 10s};

  void take(const Author& author) {
    for (const auto& record : author.written()) ASSERT_TRUE(log.apply(record, kPairStart).ok());
  }
  void take_all() {
    for (Author* author : {&a, &b, &c}) {
      author->finish();
      take(*author);
    }
  }
  Agreement at(Duration by, const std::set<RobotId>& silent = {}) {
    std::map<RobotId, Instant> last_sign;
    for (const RobotId& robot : log.robots())
      if (!silent.contains(robot)) last_sign[robot] = kPairStart + by;
    presence.update(last_sign, {});
    return {log, presence, kPairStart + by};
  }
};

TEST_F(PairVerifierTest, LooksOnceAtThePairsWithHigherRobots) {
  take(a);
  take(b);
  take(c);
  EXPECT_FALSE(verifier.next(at(1s), kPairStart + 1s, never)) << "they still map";
  for (Author* author : {&a, &b, &c}) {
    author->finish();
    ASSERT_TRUE(log.apply(author->written().back(), kPairStart).ok());
  }
  const auto look = verifier.next(at(1s), kPairStart + 1s, never);
  ASSERT_TRUE(look.has_value());
  EXPECT_TRUE(look->news) << "at the end a refusal is written as well";
  EXPECT_EQ(look->link.a, b.id());
  EXPECT_EQ(look->link.b, c.id());
  EXPECT_EQ(look->link.incarnation_other, 7u);
  EXPECT_EQ(look->link.reason, LinkReason::too_few_matches);
  EXPECT_EQ(look->link.keyframes_a, 3u);
  EXPECT_FALSE(verifier.next(at(1s), kPairStart + 1s, never));
}

TEST_F(PairVerifierTest, TakesOverWhatALowerRobotThatIsGoneCannotDo) {
  take_all();
  ASSERT_TRUE(verifier.next(at(1s), kPairStart + 1s, never)) << "its own pair, with c";
  const auto look = verifier.next(at(102s, {a.id()}), kPairStart + 102s, never);
  ASSERT_TRUE(look.has_value());
  EXPECT_EQ(look->link.a, a.id());
  EXPECT_EQ(look->link.b, b.id());
  EXPECT_EQ(look->link.incarnation_other, 1u);
}

TEST_F(PairVerifierTest, TakesOverWhatALowerRobotDoesNotDo) {
  take_all();
  ASSERT_TRUE(verifier.next(at(1s), kPairStart + 1s, never));
  EXPECT_FALSE(verifier.next(at(10s), kPairStart + 10s, never));
  const auto look = verifier.next(at(21s), kPairStart + 21s, never);
  ASSERT_TRUE(look.has_value());
  EXPECT_EQ(look->link.a, a.id());
}

TEST_F(PairVerifierTest, WhileMappingARefusalIsNoNews) {
  take(b);
  take(c);
  PairVerifier eager{{}, places, 10s, 10s};
  const auto look = eager.next(at(1s), kPairStart + 1s, never);
  ASSERT_TRUE(look.has_value());
  EXPECT_FALSE(look->news);
}

// d has more to look at than c, whose id is lower.
TEST_F(PairVerifierTest, LooksFirstWhereMostIsToBeGained) {
  Author d = test::small_robot("d");
  for (int k = 0; k < 3; ++k) d.keyframe();
  for (const Author* author : {&b, &c, &d}) take(*author);
  PairVerifier eager{{}, places, 10s, 10s};
  const auto first = eager.next(at(1s), kPairStart + 1s, never), second = eager.next(at(1s), kPairStart + 1s, never);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->link.b, d.id());
  EXPECT_EQ(second->link.b, c.id());
}

TEST_F(PairVerifierTest, StoppedItDoesNothing) {
  take_all();
  EXPECT_FALSE(verifier.next(at(1s), kPairStart + 1s, [] { return true; }));
  EXPECT_TRUE(verifier.next(at(1s), kPairStart + 1s, never));
}

}  // namespace
}  // namespace onemap::mapping
