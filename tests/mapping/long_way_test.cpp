#include "mapping/team/long_way.hpp"

#include <gtest/gtest.h>

namespace onemap::mapping {
namespace {

StampedPose at(std::int64_t ns) { return {frame_time_from_ns(ns), {}}; }

TEST(LongWay, KeepsAllAndThenEverySecondAndThenEveryFourth) {
  LongWay way(8);
  for (int i = 0; i < 8; ++i) way.add(at(i));
  EXPECT_EQ(way.poses().size(), 8u);
  EXPECT_EQ(way.each(), 1u);
  for (int i = 8; i < 1000; ++i) {
    way.add(at(i));
    ASSERT_EQ(way.added(), static_cast<std::uint64_t>(i) + 1);
    ASSERT_LE(way.poses().size(), 8u);
    ASSERT_GE(way.poses().size(), 4u);
    for (std::size_t k = 0; k < way.poses().size(); ++k)
      ASSERT_EQ(way.poses()[k].time, frame_time_from_ns(static_cast<std::int64_t>(k * way.each()))) << "evenly" << i;
    ASSERT_LT(i - static_cast<std::int64_t>((way.poses().size() - 1) * way.each()),
              static_cast<std::int64_t>(way.each()))
        << "to its end";
  }
  EXPECT_EQ(way.each(), 128u);
}

}  // namespace
}  // namespace onemap::mapping
