#include "daemon/frame_times.hpp"

#include <gtest/gtest.h>

#include <chrono>

namespace onemap::daemon {
namespace {

using namespace std::chrono_literals;
using Verdict = FrameTimes::Verdict;

struct Taken {
  Verdict verdict;
  FrameTime colour, depth;
};
Taken take(FrameTimes& times, FrameTime at) {
  FrameTime colour = at, depth = at + 5ms;
  const Verdict verdict = times.take(colour, depth);
  return {verdict, colour, depth};
}

TEST(FrameTimes, TimesThatIncreaseStayAsTheyAre) {
  FrameTimes times;
  for (int i = 0; i < 50; ++i) {
    const FrameTime at = FrameTime(1h + i * 33ms);
    const Taken taken = take(times, at);
    EXPECT_EQ(taken.verdict, Verdict::good);
    EXPECT_EQ(taken.colour, at);
    EXPECT_EQ(taken.depth, at + 5ms);
  }
  EXPECT_EQ(times.refused(), 0u);
}

TEST(FrameTimes, AClockThatWasSetBackCostsAFewFramesAndIsFollowed) {
  FrameTimes times;
  const FrameTime last = FrameTime(5h);
  EXPECT_EQ(take(times, last).verdict, Verdict::good);
  FrameTime back = FrameTime(4h);
  for (int i = 0; i < FrameTimes::kPatience; ++i, back += 33ms) EXPECT_EQ(take(times, back).verdict, Verdict::refused);
  EXPECT_EQ(times.refused(), 10u);
  Taken taken = take(times, back);
  EXPECT_EQ(taken.verdict, Verdict::moved);
  EXPECT_EQ(taken.colour, last + 33ms) << "one frame after the last one";
  EXPECT_EQ(taken.depth - taken.colour, 5ms);
  taken = take(times, back + 33ms);
  EXPECT_EQ(taken.verdict, Verdict::good);
  EXPECT_EQ(taken.colour, last + 66ms);
  taken = take(times, FrameTime(5h + 1s));
  EXPECT_EQ(taken.verdict, Verdict::returned);
  EXPECT_EQ(taken.colour, FrameTime(5h + 1s));
  EXPECT_EQ(times.shift(), Duration::zero());
}

TEST(FrameTimes, ACameraThatRepeatsOneTimeIsNotFollowed) {
  FrameTimes times;
  take(times, FrameTime(5h));
  for (int i = 0; i < 100; ++i) EXPECT_EQ(take(times, FrameTime(5h)).verdict, Verdict::refused);
  EXPECT_EQ(take(times, FrameTime(5h + 1ms)).verdict, Verdict::good);
}

}  // namespace
}  // namespace onemap::daemon
