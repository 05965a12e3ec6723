#include "hal/depth_noise.hpp"

#include <gtest/gtest.h>

namespace onemap::hal {
namespace {

TEST(DepthNoise, DefaultsAreTheKinectsAsPublished) {
  const DepthNoise kinect;
  for (const double z : {0.4, 0.5, 1.0, 2.5, 4.0, 8.0})
    EXPECT_EQ(kinect.sigma_m(z), 0.0012 + 0.0019 * (z - 0.4) * (z - 0.4)) << z;
  for (const float z : {0.4f, 0.5f, 1.0f, 2.5f, 4.0f, 8.0f})
    EXPECT_EQ(kinect.sigma_m(z), 0.0012f + 0.0019f * (z - 0.4f) * (z - 0.4f)) << z;
}

TEST(DepthNoise, IsLeastAtItsBestDistance) {
  const DepthNoise stereo{0.001, 0.004, 0.6};
  EXPECT_EQ(stereo.sigma_m(0.6), 0.001);
  EXPECT_GT(stereo.sigma_m(0.5), 0.001);
  EXPECT_NEAR(stereo.sigma_m(1.6), 0.005, 1e-12);
}

}  // namespace
}  // namespace onemap::hal
