#include "mapping/team/pair_schedule.hpp"

#include <gtest/gtest.h>

namespace onemap::mapping {
namespace {

using namespace std::chrono_literals;
using Keyframes = PairSchedule::Keyframes;

const ChainId kOther{RobotId::from_name("other"), 1}, kAnother{kOther.robot, 2};
constexpr Instant kStart{};

TEST(PairSchedule, LooksOnceWhenAllKeyframesAreHere) {
  PairSchedule schedule(0s);
  const Keyframes mine{5, true}, theirs{6, true};
  EXPECT_FALSE(schedule.due({5, false}, kOther, theirs, kStart)) << "without an interval only at the end";
  EXPECT_TRUE(schedule.due(mine, kOther, theirs, kStart));
  schedule.verified(mine, kOther, theirs, false, kStart);
  EXPECT_FALSE(schedule.due(mine, kOther, theirs, kStart + 1000s));
  EXPECT_TRUE(schedule.due(mine, kAnother, {6, true}, kStart)) << "another life";
  EXPECT_TRUE(schedule.due(mine, kOther, {7, true}, kStart)) << "more of a robot that was given up came after all";
  EXPECT_FALSE(schedule.due(mine, kAnother, {0, true}, kStart)) << "nothing to look at";
}

TEST(PairSchedule, WhileMappingLooksAtMostSoOften) {
  PairSchedule schedule(10s);
  const Keyframes mine{4, false};
  EXPECT_FALSE(schedule.due(mine, kOther, {2, false}, kStart)) << "too few";
  EXPECT_TRUE(schedule.due(mine, kOther, {3, false}, kStart));
  schedule.verified(mine, kOther, {3, false}, false, kStart);
  EXPECT_FALSE(schedule.due(mine, kOther, {4, false}, kStart + 9s));
  EXPECT_TRUE(schedule.due(mine, kOther, {4, false}, kStart + 10s));
  EXPECT_FALSE(schedule.due(mine, kOther, {3, false}, kStart + 10s)) << "nothing new";
  schedule.verified(mine, kOther, {4, false}, true, kStart + 10s);
  EXPECT_TRUE(schedule.linked(kOther));
  EXPECT_FALSE(schedule.linked(kAnother));
  EXPECT_FALSE(schedule.due(mine, kOther, {7, false}, kStart + 100s)) << "linked, and not half as much again";
  EXPECT_TRUE(schedule.due(mine, kOther, {8, false}, kStart + 100s));
}

TEST(PairSchedule, CostlyLooksAreRarer) {
  PairSchedule schedule(10s);
  const Keyframes mine{4, false};
  schedule.verified(mine, kOther, {3, false}, false, kStart);
  schedule.took(kOther, 5s);
  EXPECT_FALSE(schedule.due(mine, kOther, {4, false}, kStart + 54s));
  EXPECT_TRUE(schedule.due(mine, kOther, {4, false}, kStart + 55s));
}

// However many chains there are, other work has its turn.
TEST(PairSchedule, AllChainsTogetherTakeAThirdOfTheTime) {
  PairSchedule schedule(10s);
  const Keyframes mine{4, false}, theirs{3, false};
  schedule.verified(mine, kOther, theirs, false, kStart);
  schedule.took(kOther, 5s);
  EXPECT_FALSE(schedule.due(mine, kAnother, theirs, kStart + 14s));
  EXPECT_TRUE(schedule.due(mine, kAnother, theirs, kStart + 15s));
  EXPECT_TRUE(schedule.due({4, true}, kAnother, {3, true}, kStart + 6s)) << "the end does not wait";
}

TEST(PairSchedule, ALinkThatIsNotThereIsMoreThanKeyframes) {
  PairSchedule schedule(10s);
  const Keyframes mine{4, false};
  schedule.verified(mine, kOther, {4, false}, true, kStart);
  EXPECT_GT(schedule.gain(mine, kAnother, {3, false}), schedule.gain(mine, kOther, {90, false}));
  schedule.verified(mine, kAnother, {3, false}, true, kStart);
  EXPECT_LT(schedule.gain(mine, kAnother, {5, false}), schedule.gain(mine, kOther, {90, false}));
}

// What a few keyframes more make whole again does not part a map for an interval.
TEST(PairSchedule, ALinkIsGoneWhenItIsRefusedTwiceInARow) {
  PairSchedule schedule(10s);
  const Keyframes mine{4, false};
  schedule.verified(mine, kOther, {4, false}, true, kStart);
  schedule.verified(mine, kOther, {8, false}, false, kStart + 10s);
  EXPECT_TRUE(schedule.linked(kOther)) << "in doubt";
  EXPECT_FALSE(schedule.due(mine, kOther, {8, false}, kStart + 20s));
  EXPECT_TRUE(schedule.due(mine, kOther, {9, false}, kStart + 20s)) << "with the next keyframe";
  schedule.verified(mine, kOther, {9, false}, true, kStart + 20s);
  schedule.verified(mine, kOther, {14, false}, false, kStart + 30s);
  EXPECT_TRUE(schedule.linked(kOther)) << "accepted in between";
  schedule.verified(mine, kOther, {15, false}, false, kStart + 40s);
  EXPECT_FALSE(schedule.linked(kOther));
  schedule.verified(mine, kOther, {16, false}, false, kStart + 50s);
  EXPECT_FALSE(schedule.linked(kOther));
}

TEST(PairSchedule, AtTheEndARefusalCountsAtOnce) {
  PairSchedule schedule(10s);
  schedule.verified({4, false}, kOther, {4, false}, true, kStart);
  schedule.verified({8, true}, kOther, {8, true}, false, kStart + 1s);
  EXPECT_FALSE(schedule.linked(kOther));
}

}  // namespace
}  // namespace onemap::mapping
