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

}  // namespace
}  // namespace onemap::mapping
