#include "session/receive_window.hpp"

#include <gtest/gtest.h>

namespace onemap::comms {
namespace {

TEST(ReceiveWindow, TakesEachCounterOnce) {
  ReceiveWindow window;
  for (const std::uint32_t counter : {5u, 7u, 6u, 100u, 50u}) {
    EXPECT_EQ(window.accept(counter).verdict, ReceiveWindow::Verdict::fresh);
    EXPECT_EQ(window.accept(counter).verdict, ReceiveWindow::Verdict::duplicate);
  }
  EXPECT_EQ(window.accept(100 + 2047).verdict, ReceiveWindow::Verdict::fresh);
  EXPECT_EQ(window.accept(101).verdict, ReceiveWindow::Verdict::fresh);
  EXPECT_EQ(window.accept(99).verdict, ReceiveWindow::Verdict::too_old);
}

// A week at full rate: after 2^32 - 1 comes 1, and the peer goes on listening.
TEST(ReceiveWindow, CountersGoRound) {
  ReceiveWindow window;
  std::uint64_t last = 0;
  for (std::uint64_t round = 0; round < 3; ++round) {
    for (std::uint64_t at = 0xFFFFFFFF - 3000; at <= 0xFFFFFFFF; ++at) {
      const auto arrival = window.accept(static_cast<std::uint32_t>(at));
      if (at > 0xFFFFFFFF - 2990) {
        ASSERT_EQ(arrival.verdict, ReceiveWindow::Verdict::fresh) << at;
        ASSERT_GT(arrival.at, last);
      }
      last = arrival.at;
    }
    for (std::uint32_t at = 1; at < 3000; ++at) {
      const auto arrival = window.accept(at);
      ASSERT_EQ(arrival.verdict, ReceiveWindow::Verdict::fresh) << at;
      ASSERT_GT(arrival.at, last);
      last = arrival.at;
    }
    EXPECT_EQ(window.accept(2999).verdict, ReceiveWindow::Verdict::duplicate);
    EXPECT_EQ(window.accept(2000).verdict, ReceiveWindow::Verdict::duplicate);
  }
  EXPECT_LT(window.loss(), 0.05);
}

TEST(ReceiveWindow, OneForgedCounterShutsNobodyOut) {
  for (const std::uint32_t forged : {0xFFFFFFFFu, 0x7FFFFFFFu, 0x80000000u, 50'000u}) {
    ReceiveWindow window;
    for (std::uint32_t counter = 1; counter <= 100; ++counter) window.accept(counter);
    window.accept(forged);
    for (std::uint32_t counter = 101; counter <= 200; ++counter)
      ASSERT_EQ(window.accept(counter).verdict, ReceiveWindow::Verdict::fresh) << forged;
  }
}

// Even when two forged ones have moved the window, two true ones bring it back.
TEST(ReceiveWindow, AFarStreamIsFollowedWhenItsNextConfirmsIt) {
  ReceiveWindow window;
  for (std::uint32_t counter = 1; counter <= 100; ++counter) window.accept(counter);
  EXPECT_EQ(window.accept(1'000'000).verdict, ReceiveWindow::Verdict::jump);
  EXPECT_EQ(window.accept(1'000'000).verdict, ReceiveWindow::Verdict::jump) << "a copy confirms nothing";
  EXPECT_EQ(window.accept(1'000'003).verdict, ReceiveWindow::Verdict::fresh);
  EXPECT_EQ(window.accept(101).verdict, ReceiveWindow::Verdict::too_old);
  EXPECT_EQ(window.accept(102).verdict, ReceiveWindow::Verdict::fresh);
  EXPECT_EQ(window.accept(103).verdict, ReceiveWindow::Verdict::fresh);
}

TEST(ReceiveWindow, EstimatesLoss) {
  ReceiveWindow window;
  for (std::uint32_t counter = 1; counter < 2000; ++counter)
    if (counter % 4 != 0) window.accept(counter);
  EXPECT_NEAR(window.loss(), 0.25, 0.02);
}

}  // namespace
}  // namespace onemap::comms
