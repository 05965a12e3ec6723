#include "mapping/local/smooth_odometry.hpp"

#include <gtest/gtest.h>

namespace onemap::mapping {
namespace {

FrameReport placed(double x, bool relocalized = false) {
  FrameReport out;
  out.state = TrackState::tracking;
  out.relocalized = relocalized;
  out.T_robot_camera.t = {x, 0, 0};
  return out;
}

TEST(SmoothOdometry, IsTheMappersUntilItJumps) {
  SmoothOdometry odometry;
  for (const double x : {0.0, 0.1, 0.25}) {
    odometry.add(placed(x));
    EXPECT_DOUBLE_EQ(odometry.camera_in_odom().t.x(), x);
    EXPECT_NEAR(odometry.robot_in_odom().t.norm(), 0, 1e-12);
  }
}

TEST(SmoothOdometry, AJumpIsTheCorrections) {
  SmoothOdometry odometry;
  for (const double x : {0.0, 0.1}) odometry.add(placed(x));
  FrameReport lost;
  lost.state = TrackState::lost;
  lost.T_robot_camera.t = {77, 0, 0};
  odometry.add(lost);
  EXPECT_DOUBLE_EQ(odometry.camera_in_odom().t.x(), 0.1) << "where it was last";
  odometry.add(placed(5, true));
  EXPECT_NEAR(odometry.camera_in_odom().t.x(), 0.1, 1e-12);
  EXPECT_NEAR(odometry.robot_in_odom().t.x(), -4.9, 1e-12);
  odometry.add(placed(5.2));
  EXPECT_NEAR(odometry.camera_in_odom().t.x(), 0.3, 1e-12);
  EXPECT_NEAR((odometry.robot_in_odom() * Vector3d(5.2, 0, 0)).x(), 0.3, 1e-12);
}

TEST(SmoothOdometry, AFrameWhoseTimeIsOutOfOrderChangesNothing) {
  SmoothOdometry odometry;
  for (const double x : {0.0, 0.1}) odometry.add(placed(x));
  FrameReport late = placed(0);
  late.reason = TrackReason::time_not_increasing;
  odometry.add(late);
  EXPECT_DOUBLE_EQ(odometry.camera_in_odom().t.x(), 0.1);
  odometry.add(placed(0.2));
  EXPECT_NEAR(odometry.camera_in_odom().t.x(), 0.2, 1e-12);
}

TEST(SmoothOdometry, AnotherChainGoesOnWhereTheLastOneEnded) {
  SmoothOdometry odometry;
  for (const double x : {0.0, 0.1}) odometry.add(placed(x));
  odometry.begin_chain();
  EXPECT_DOUBLE_EQ(odometry.camera_in_odom().t.x(), 0.1);
  for (const double x : {0.0, 0.3}) odometry.add(placed(x));
  EXPECT_NEAR(odometry.camera_in_odom().t.x(), 0.4, 1e-12);
  EXPECT_NEAR(odometry.robot_in_odom().t.x(), 0.1, 1e-12);
}

}  // namespace
}  // namespace onemap::mapping
