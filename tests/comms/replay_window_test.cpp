#include "session/replay_window.hpp"

#include <gtest/gtest.h>

namespace onemap::comms {
namespace {

TEST(ReplayWindow, TakesEachCounterOnceInAnyOrder) {
  ReplayWindow window;
  for (const std::uint64_t counter : {5u, 7u, 6u, 100u, 50u}) {
    EXPECT_EQ(window.accept(counter), ReplayWindow::Verdict::fresh);
    EXPECT_EQ(window.accept(counter), ReplayWindow::Verdict::duplicate);
  }
  EXPECT_EQ(window.highest(), 100u);
}

TEST(ReplayWindow, Reaches8192Back) {
  ReplayWindow window;
  window.accept(10'000);
  EXPECT_EQ(window.accept(10'000 - 8191), ReplayWindow::Verdict::fresh);
  EXPECT_EQ(window.accept(10'000 - 8191), ReplayWindow::Verdict::duplicate);
  EXPECT_EQ(window.accept(10'000 - 8192), ReplayWindow::Verdict::too_old);
  EXPECT_EQ(window.accept(10'001), ReplayWindow::Verdict::fresh);
  EXPECT_EQ(window.accept(10'001 - 8192), ReplayWindow::Verdict::too_old);
}

TEST(ReplayWindow, AJumpForgetsWhatItJumpedOver) {
  ReplayWindow window;
  for (std::uint64_t c = 1; c <= 100; ++c) window.accept(c);
  const std::uint64_t far = std::uint64_t{1} << 40;
  EXPECT_EQ(window.accept(far), ReplayWindow::Verdict::fresh);
  EXPECT_EQ(window.accept(100), ReplayWindow::Verdict::too_old);
  for (std::uint64_t c = far - 8191; c < far; ++c) ASSERT_EQ(window.accept(c), ReplayWindow::Verdict::fresh);
  for (std::uint64_t c = far - 8191; c <= far; ++c) ASSERT_EQ(window.accept(c), ReplayWindow::Verdict::duplicate);
}

TEST(ReplayWindow, EstimatesLoss) {
  ReplayWindow window;
  for (std::uint64_t counter = 1; counter < 2000; ++counter)
    if (counter % 4 != 0) window.accept(counter);
  EXPECT_NEAR(window.loss(), 0.25, 0.02);
}

}  // namespace
}  // namespace onemap::comms
