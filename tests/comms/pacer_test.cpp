#include "pacer.hpp"

#include <gtest/gtest.h>

namespace onemap::comms {
namespace {
using namespace std::chrono_literals;

std::size_t sent_in(Pacer& pacer, Instant& now, Duration time, std::size_t each) {
  std::size_t bytes = 0;
  for (const Instant end = now + time; now < end; now += 1ms)
    while (pacer.open(now)) {
      pacer.sent(now, each);
      bytes += each;
    }
  return bytes;
}

TEST(Pacer, KeepsTheRateAndSendsInTrains) {
  Pacer pacer(1'000'000, 8);
  Instant now{1s};
  std::size_t train = 0;
  while (pacer.open(now)) pacer.sent(now, 1200), ++train;
  EXPECT_EQ(train, 8u);
  EXPECT_GT(pacer.next(), now);
  EXPECT_NEAR(static_cast<double>(sent_in(pacer, now, 1s, 1200)), 1e6, 3000);
  now += 10s;  // a pause saves up one train, no more
  train = 0;
  while (pacer.open(now)) pacer.sent(now, 1200), ++train;
  EXPECT_EQ(train, 8u);
}

TEST(Pacer, WhatDoesNotWaitUsesUpTheRate) {
  Pacer pacer(1'000'000, 1);
  Instant now{1s};
  for (int k = 0; k < 100; ++k) pacer.sent(now, 1000);  // control
  EXPECT_EQ(pacer.next(), now + 100ms);
}

TEST(Pacer, NoRateIsTheSlowest) {
  Pacer pacer(0, 0);
  const Instant now{1s};
  pacer.sent(now, 10);
  EXPECT_EQ(pacer.next(), now + 10s);
}

}  // namespace
}  // namespace onemap::comms
