#include "hal/lens.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "support/kinect_lens.hpp"

namespace onemap::hal {
namespace {

TEST(Lens, RaysFallOnTheirPixels) {
  const Intrinsics k = test::kinect_lens();
  for (int v = 0; v < k.height; v += 13)
    for (int u = 0; u < k.width; u += 11) {
      const Point2 pixel{static_cast<double>(u), static_cast<double>(v)}, back = pixel_of(k, ray_of(k, pixel));
      EXPECT_NEAR(back.x, u, 1e-6);
      EXPECT_NEAR(back.y, v, 1e-6);
      EXPECT_TRUE(has_ray(k, pixel));
    }
}

TEST(Lens, WithoutDistortionIsAPinhole) {
  const Intrinsics k;
  EXPECT_EQ(ray_of(k, {424.5, 134.5}), (Point2{0.2, -0.2}));
  EXPECT_EQ(pixel_of(k, {0.2, -0.2}), (Point2{424.5, 134.5}));
}

// The tangential terms as OpenCV has them: p1 bends along y, p2 along x.
TEST(Lens, TangentialTermsBendTheirOwnAxis) {
  Intrinsics k;
  k.p1 = 0.01;
  EXPECT_NEAR(pixel_of(k, {0.2, 0}).y - k.cy, 525 * 0.01 * 0.04, 1e-9);
  k.p1 = 0;
  k.p2 = 0.01;
  EXPECT_NEAR(pixel_of(k, {0.2, 0}).x - k.cx, 525 * (0.2 + 0.01 * 0.12), 1e-9);
}

TEST(Lens, SaysWhereItCannotBeInverted) {
  Intrinsics k;
  k.k1 = -3;  // folds the image over well before its corner
  EXPECT_TRUE(has_ray(k, {319, 239}));
  EXPECT_FALSE(has_ray(k, {0, 0}));
  k.k1 = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(has_ray(k, {100, 100}));
}

}  // namespace
}  // namespace onemap::hal
