#include "hal/base/bounded_queue.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>
#include <vector>

namespace onemap {
namespace {

TEST(BlockingQueue, FirstInFirstOutAroundTheRing) {
  BlockingQueue<int> queue(3);
  EXPECT_EQ(queue.capacity(), 3u);
  int in = 0, out = 0;
  for (int round = 0; round < 10; ++round) {
    EXPECT_TRUE(queue.push(in++));
    EXPECT_TRUE(queue.push(in++));
    EXPECT_EQ(queue.used(), 2u);
    EXPECT_EQ(queue.pop(), out++);
    EXPECT_EQ(queue.try_pop(), out++);
  }
  EXPECT_EQ(queue.try_pop(), std::nullopt);
  EXPECT_EQ(queue.used(), 0u);
}

TEST(BlockingQueue, DropsTheOldestAndCounts) {
  BlockingQueue<int> queue(2);
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(queue.push_dropping_oldest(i));
  EXPECT_EQ(queue.dropped(), 3u);
  EXPECT_EQ(queue.pop(), 3);
  EXPECT_EQ(queue.pop(), 4);
}

TEST(BlockingQueue, WhatIsTakenOrDroppedIsGone) {
  auto item = std::make_shared<int>(1);
  BlockingQueue<std::shared_ptr<int>> queue(1);
  queue.push(item);
  EXPECT_EQ(item.use_count(), 2);
  queue.push_dropping_oldest(nullptr);
  EXPECT_EQ(item.use_count(), 1);
  queue.pop();
  queue.push(item);
  queue.pop();
  EXPECT_EQ(item.use_count(), 1);  // the ring keeps nothing alive
}

TEST(BlockingQueue, CloseLetsTheRestOutAndNothingIn) {
  BlockingQueue<int> queue(2);
  queue.push(1);
  queue.close();
  EXPECT_FALSE(queue.push(2));
  EXPECT_FALSE(queue.push_dropping_oldest(2));
  EXPECT_EQ(queue.pop(), 1);
  EXPECT_EQ(queue.pop(), std::nullopt);
}

TEST(BlockingQueue, CloseWakesWhoeverWaits) {
  BlockingQueue<int> empty(1), full(1);
  full.push(0);
  std::atomic<int> woken = 0;
  std::thread consumer([&] { woken += empty.pop() == std::nullopt; });
  std::thread producer([&] { woken += !full.push(1); });
  empty.close();
  full.close();
  consumer.join();
  producer.join();
  EXPECT_EQ(woken, 2);
}

TEST(BlockingQueue, NothingIsLostBetweenThreads) {
  BlockingQueue<std::unique_ptr<int>> queue(4);
  constexpr int kItems = 5000;
  std::vector<std::thread> producers;
  for (int p = 0; p < 2; ++p)
    producers.emplace_back([&queue, p] {
      for (int i = p; i < kItems; i += 2) queue.push(std::make_unique<int>(i));
    });
  std::vector<int> last = {-1, -1};
  int count = 0;
  for (; count < kItems; ++count) {
    const auto item = queue.pop();
    ASSERT_TRUE(item.has_value());
    int& before = last[static_cast<std::size_t>(**item % 2)];
    EXPECT_LT(before, **item);  // each producer's order is kept
    before = **item;
  }
  for (std::thread& thread : producers) thread.join();
  EXPECT_EQ(queue.used(), 0u);
}

}  // namespace
}  // namespace onemap
