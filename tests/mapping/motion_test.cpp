#include "local/tracking/motion.hpp"

#include <gtest/gtest.h>

namespace onemap::mapping {
namespace {

FrameTime at_ms(int ms) { return FrameTime{} + std::chrono::milliseconds(ms); }

// A steady hand: so far along x, and turned so far about y, after so many milliseconds.
Pose steady(int ms) {
  Vector6d wv;
  wv << 0, 2e-4 * ms, 0, 5e-4 * ms, 0, 0;
  return small_motion(wv);
}

TEST(Motion, SaysNothingBeforeThereIsAPose) { EXPECT_FALSE(Motion{}.at(at_ms(10))); }

TEST(Motion, ExpectsASteadyHandToGoOn) {
  Motion motion;
  for (int ms = 0; ms <= 300; ms += 30) motion.follow(at_ms(ms), steady(ms));
  const auto expected = motion.at(at_ms(330));
  ASSERT_TRUE(expected);
  EXPECT_LT(motion_between(steady(330), expected->T_camera_robot).norm(), 1e-3);
  EXPECT_GT(motion_between(steady(300), expected->T_camera_robot).norm(), 0.01);
}

TEST(Motion, IsLessSureTheLongerItIsAgo) {
  Motion motion;
  motion.follow(at_ms(0), Pose{});
  const auto soon = motion.at(at_ms(30)), late = motion.at(at_ms(90));
  ASSERT_TRUE(soon && late);
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(soon->information(i, i), 9 * late->information(i, i), 1e-6) << i;
}

TEST(Motion, ForgetsWhatIsLongAgo) {
  Motion motion;
  for (int ms = 0; ms <= 300; ms += 30) motion.follow(at_ms(ms), steady(ms));
  EXPECT_FALSE(motion.at(at_ms(601)));
  EXPECT_FALSE(motion.at(at_ms(300))) << "no time has passed";
  motion.follow(at_ms(900), steady(300));
  const auto expected = motion.at(at_ms(930));
  ASSERT_TRUE(expected);
  EXPECT_LT(motion_between(steady(300), expected->T_camera_robot).norm(), 1e-9) << "nobody knows how it moved since";
}

// One wrong pose among right ones does not take the camera along.
TEST(Motion, SmoothsWhatOneFrameSays) {
  Motion motion;
  for (int ms = 0; ms <= 600; ms += 30) motion.follow(at_ms(ms), Pose{});
  motion.follow(at_ms(630), Pose{Matrix3d::Identity(), {0.01, 0, 0}});
  const auto expected = motion.at(at_ms(660));
  ASSERT_TRUE(expected);
  EXPECT_LT(expected->T_camera_robot.t.x(), 0.013);
  EXPECT_GT(expected->T_camera_robot.t.x(), 0.01);
}

}  // namespace
}  // namespace onemap::mapping
