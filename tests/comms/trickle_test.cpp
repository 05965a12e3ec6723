#include "trickle.hpp"

#include <gtest/gtest.h>

namespace onemap::comms {
namespace {
using namespace std::chrono_literals;

TEST(Trickle, IntervalsDoubleWhileNothingChanges) {
  SplitMix random(1);
  Trickle trickle(250ms, 4s);
  Instant now{10s};
  EXPECT_TRUE(trickle.due(now)) << "at the start";
  for (const Duration interval : {250ms, 500ms, 1000ms, 2000ms, 4000ms, 4000ms}) {
    trickle.said(now, 4s, random);
    EXPECT_GE(trickle.next(), now + interval / 2);
    EXPECT_LE(trickle.next(), now + interval);
    EXPECT_FALSE(trickle.due(trickle.next() - 1ns));
    now = trickle.next();
    EXPECT_TRUE(trickle.due(now));
  }
  trickle.said(now, 500ms, random);
  EXPECT_LE(trickle.next(), now + 500ms) << "no longer than asked for";
}

TEST(Trickle, AChangeIsSaidAtOnceButNotTooOften) {
  SplitMix random(1);
  Trickle trickle(250ms, 4s);
  Instant now{10s};
  for (int k = 0; k < 6; ++k) trickle.said(now, 4s, random);
  now += 500ms;
  trickle.changed(now);
  EXPECT_TRUE(trickle.due(now));
  trickle.said(now, 4s, random);
  EXPECT_LE(trickle.next(), now + 250ms) << "and the interval is short again";
  trickle.changed(now + 1ms);
  EXPECT_EQ(trickle.next(), now + 100ms);
}

}  // namespace
}  // namespace onemap::comms
