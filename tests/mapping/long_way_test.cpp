#include "mapping/team/long_way.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/poses.hpp"

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

// As a camera moves, with what no camera does in between.
TEST(LongWay, GivesBackWhatItWasGivenAndTakesHalfOfIt) {
  test::Random random(5);
  LongWay way(1000);
  std::vector<StampedPose> given;
  for (int i = 0; i < 1000; ++i) {
    StampedPose pose = at(1'600'000'000'000'000'000 + i * 33'333'333LL);
    pose.T_robot_camera = quantize({test::rotation({0.2, 0.3, 1}, 0.02 * i), {0.01 * i, std::sin(0.05 * i), 0.5}});
    for (std::int32_t& q : pose.T_robot_camera.q_wxyz)
      q += static_cast<std::int32_t>(random.uniform(-500'000, 500'000));
    given.push_back(pose);
  }
  constexpr std::int32_t kMost = std::numeric_limits<std::int32_t>::max(),
                         kLeast = std::numeric_limits<std::int32_t>::min();
  given[100].T_robot_camera = {{kMost, kLeast, 0}, {kLeast, kMost, kLeast, -1}};
  given[200].time = frame_time_from_ns(std::numeric_limits<std::int64_t>::max());
  given[201].time = frame_time_from_ns(std::numeric_limits<std::int64_t>::min());
  for (const StampedPose& pose : given) way.add(pose);
  const std::vector<StampedPose> back = way.poses();
  ASSERT_EQ(back.size(), given.size());
  for (std::size_t i = 0; i < back.size(); ++i) {
    ASSERT_EQ(back[i].time, given[i].time) << i;
    ASSERT_EQ(back[i].T_robot_camera, given[i].T_robot_camera) << i;
  }
  EXPECT_LT(way.bytes(), 22 * given.size());
}

}  // namespace
}  // namespace onemap::mapping
