#include "hal/frame_pool.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <thread>
#include <type_traits>
#include <vector>

namespace onemap::hal {
namespace {

Intrinsics small() {
  Intrinsics k;
  k.width = 6;
  k.height = 4;
  return k;
}

static_assert(!std::is_copy_constructible_v<Frame> && std::is_nothrow_move_constructible_v<Frame>);

TEST(FramePool, FramesHaveTheirOwnMemory) {
  FramePool pool(small(), 2);
  EXPECT_EQ(pool.capacity(), 2u);
  EXPECT_EQ(pool.bytes(), 2u * 24 * 5);
  Frame a = pool.acquire(), b = pool.acquire();
  ASSERT_EQ(a.rgb().size(), 72u);
  ASSERT_EQ(a.depth().size(), 24u);
  std::ranges::fill(a.rgb(), std::uint8_t{1});
  std::ranges::fill(a.depth(), std::uint16_t{2});
  std::ranges::fill(b.rgb(), std::uint8_t{3});
  std::ranges::fill(b.depth(), std::uint16_t{4});
  EXPECT_TRUE(std::ranges::all_of(a.rgb(), [](auto v) { return v == 1; }));
  EXPECT_TRUE(std::ranges::all_of(a.depth(), [](auto v) { return v == 2; }));
}

TEST(FramePool, FullIsAStateAndFramesComeBack) {
  FramePool pool(small(), 1);
  {
    const Frame only = pool.acquire();
    EXPECT_TRUE(only);
    EXPECT_EQ(pool.used(), pool.capacity());
  }
  EXPECT_EQ(pool.used(), 0u);
  EXPECT_TRUE(pool.acquire());
}

TEST(FramePool, MovingHandsTheLoanOver) {
  FramePool pool(small(), 2);
  Frame a = pool.acquire();
  a.index = 7;
  a.colour_time = frame_time_from_ns(9);
  a.depth_time = frame_time_from_ns(8);
  Frame b = std::move(a);
  EXPECT_FALSE(a);  // NOLINT(bugprone-use-after-move): a moved-from frame is empty
  EXPECT_EQ(b.index, 7u);
  Frame c = pool.acquire();
  EXPECT_EQ(pool.used(), 2u);
  c = std::move(b);  // gives its own slot back
  EXPECT_EQ(pool.used(), 1u);
  EXPECT_EQ(c.colour_time, frame_time_from_ns(9));
  EXPECT_EQ(c.depth_time, frame_time_from_ns(8));
  c = Frame{};
  EXPECT_EQ(pool.used(), 0u);
}

TEST(FramePool, TheViewShowsTheFrame) {
  FramePool pool(small(), 1);
  Frame frame = pool.acquire();
  frame.index = 3;
  frame.colour_time = frame_time_from_ns(5);
  frame.depth_time = frame_time_from_ns(6);
  frame.depth()[23] = 77;
  const FrameView view = frame.view();
  EXPECT_EQ(view.index, 3u);
  EXPECT_EQ(view.colour_time, frame_time_from_ns(5));
  EXPECT_EQ(view.depth_time, frame_time_from_ns(6));
  EXPECT_EQ(view.depth[23], 77);
  EXPECT_EQ(view.rgb.data(), frame.rgb().data());
  EXPECT_EQ(view.intrinsics, &pool.intrinsics());
}

TEST(FramePool, BorrowedDepthIsShownAndGivenBackOnce) {
  FramePool pool(small(), 2);
  const auto returned = std::make_shared<std::vector<std::uint32_t>>();
  const std::vector<std::uint16_t> device(24, 9);
  const auto loan = [&](std::uint32_t buffer) {
    return DepthLoan{device, returned,
                     [](void* to, std::uint32_t b) { static_cast<std::vector<std::uint32_t>*>(to)->push_back(b); },
                     buffer};
  };
  {
    Frame frame = pool.acquire();
    frame.borrow(loan(4));
    EXPECT_EQ(frame.view().depth.data(), device.data());
    Frame other = std::move(frame);
    EXPECT_EQ(other.view().depth.data(), device.data());
    EXPECT_TRUE(returned->empty());
    other.borrow(loan(5));
    EXPECT_EQ(*returned, std::vector<std::uint32_t>({4}));
    other.return_loan();
    EXPECT_EQ(other.view().depth.data(), other.depth().data());
    other.borrow(loan(6));
  }
  EXPECT_EQ(*returned, std::vector<std::uint32_t>({4, 5, 6}));
  EXPECT_EQ(returned.use_count(), 1);
}

TEST(FramePool, AcquireWaitsForAReturn) {
  FramePool pool(small(), 1);
  std::optional<Frame> held(pool.acquire());
  std::thread returner([&] { held.reset(); });
  const Frame next = pool.acquire();
  returner.join();
  EXPECT_TRUE(next);
}

}  // namespace
}  // namespace onemap::hal
