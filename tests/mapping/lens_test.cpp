#include "mapping/local/lens.hpp"

#include <gtest/gtest.h>

namespace onemap::mapping {
namespace {

hal::Intrinsics kinect() {
  return {.fx = 517.306408,
          .fy = 516.469215,
          .cx = 318.643040,
          .cy = 255.313989,
          .k1 = 0.262383,
          .k2 = -0.953104,
          .p1 = -0.005358,
          .p2 = 0.002628,
          .k3 = 1.163314};
}

TEST(Lens, RaysFallOnTheirPixels) {
  const hal::Intrinsics k = kinect();
  for (int v = 0; v < k.height; v += 13)
    for (int u = 0; u < k.width; u += 11) {
      const Eigen::Vector2d back = distorted_pixel(k, undistorted_ray(k, u, v));
      EXPECT_NEAR(back.x(), u, 1e-6);
      EXPECT_NEAR(back.y(), v, 1e-6);
      EXPECT_TRUE(inverts(k, u, v));
    }
}

TEST(Lens, WithoutDistortionIsAPinhole) {
  const hal::Intrinsics k;
  EXPECT_EQ(undistorted_ray(k, 424.5, 134.5), Eigen::Vector2d(0.2, -0.2));
  EXPECT_EQ(distorted_pixel(k, {0.2, -0.2}), Eigen::Vector2d(424.5, 134.5));
}

// The tangential terms as OpenCV has them: p1 bends along y, p2 along x.
TEST(Lens, TangentialTermsBendTheirOwnAxis) {
  hal::Intrinsics k;
  k.p1 = 0.01;
  EXPECT_NEAR(distorted_pixel(k, {0.2, 0}).y() - k.cy, 525 * 0.01 * 0.04, 1e-9);
  k.p1 = 0;
  k.p2 = 0.01;
  EXPECT_NEAR(distorted_pixel(k, {0.2, 0}).x() - k.cx, 525 * (0.2 + 0.01 * 0.12), 1e-9);
}

TEST(Lens, SaysWhereItCannotBeInverted) {
  hal::Intrinsics k;
  k.k1 = -3;  // folds the image over well before its corner
  EXPECT_TRUE(inverts(k, 319, 239));
  EXPECT_FALSE(inverts(k, 0, 0));
  k.k1 = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(inverts(k, 100, 100));
}

}  // namespace
}  // namespace onemap::mapping
