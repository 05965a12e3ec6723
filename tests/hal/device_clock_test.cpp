#include "hal/device_clock.hpp"

#include <gtest/gtest.h>

namespace onemap::hal {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

TEST(DeviceClockTest, AddsTheOffsetAndGoesOnAfterARestart) {
  DeviceClock clock{seconds(100)};
  EXPECT_EQ(clock.at(milliseconds(33)), frame_time_from_ns(100'033'000'000));
  EXPECT_EQ(clock.at(milliseconds(66)), frame_time_from_ns(100'066'000'000));
  EXPECT_EQ(clock.at(milliseconds(60)), frame_time_from_ns(100'060'000'000))
      << "depth's may be a little before colour's";
  clock.came_back(milliseconds(500));
  EXPECT_EQ(clock.at(milliseconds(1)), frame_time_from_ns(100'566'000'000));
  EXPECT_EQ(clock.at(milliseconds(34)), frame_time_from_ns(100'599'000'000));
  clock.came_back({});
  EXPECT_EQ(clock.at(milliseconds(1)), frame_time_from_ns(100'699'000'000))
      << "time goes on even when nothing was waited";
}

TEST(DeviceClockTest, AClockThatWentOnIsTakenAtItsWord) {
  DeviceClock clock{{}};
  clock.at(seconds(1));
  clock.came_back(seconds(5));
  EXPECT_EQ(clock.at(seconds(3)), frame_time_from_ns(3'000'000'000));
}

}  // namespace
}  // namespace onemap::hal
