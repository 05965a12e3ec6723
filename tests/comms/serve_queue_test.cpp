#include "peer/serve_queue.hpp"

#include <gtest/gtest.h>

namespace onemap::comms {
namespace {

RecordId record(std::uint8_t lane) { return {{RobotId::from_name("a"), lane, 1}, 0}; }
constexpr std::size_t kCredit = 100 * wire::kFragmentBytes;

TEST(ServeQueue, ServesRangesInTheOrderOfAsking) {
  ServeQueue queue;
  const auto large = record(3);
  EXPECT_EQ(queue.push(large, 2, 10, 12, kCredit), ServeQueue::Answer::queued);
  EXPECT_EQ(queue.push(large, 2, 0, 1, kCredit), ServeQueue::Answer::queued);
  for (const std::uint16_t fragment : {10, 11, 0}) {
    ASSERT_FALSE(queue.empty(3));
    EXPECT_EQ(queue.front(3).fragment, fragment);
    EXPECT_EQ(queue.front(3).hops, 2);
    queue.pop(3);
  }
  EXPECT_TRUE(queue.empty());
}

TEST(ServeQueue, WhatWaitsIsNotQueuedAgain) {
  ServeQueue queue;
  const auto large = record(3);
  EXPECT_EQ(queue.push(large, 0, 10, 20, kCredit), ServeQueue::Answer::queued);
  EXPECT_EQ(queue.push(large, 0, 12, 18, kCredit), ServeQueue::Answer::already_queued);
  EXPECT_EQ(queue.push(large, 0, 15, 22, kCredit), ServeQueue::Answer::queued);
  std::size_t sent = 0;
  for (; !queue.empty(3); queue.pop(3)) ++sent;
  EXPECT_EQ(sent, 12u);
}

TEST(ServeQueue, CreditAndRangesAreBounds) {
  ServeQueue queue;
  const auto large = record(3);
  EXPECT_EQ(queue.push(large, 0, 0, 101, kCredit), ServeQueue::Answer::over_credit);
  EXPECT_EQ(queue.push(large, 0, 0, 100, kCredit), ServeQueue::Answer::queued);
  EXPECT_EQ(queue.push(large, 0, 100, 101, kCredit), ServeQueue::Answer::over_credit);
  ServeQueue many;
  std::size_t ranges = 0;
  while (many.push(record(3), 0, 0, 1, std::size_t{1} << 40) == ServeQueue::Answer::queued && ranges < 5000)
    many.push(record(2), 0, 0, 1, std::size_t{1} << 40), ++ranges;
  EXPECT_LE(ranges, 1u) << "the same record waits once";
}

}  // namespace
}  // namespace onemap::comms
