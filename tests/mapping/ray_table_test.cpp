#include "mapping/local/ray_table.hpp"

#include <gtest/gtest.h>

#include "hal/lens.hpp"
#include "support/kinect_lens.hpp"

namespace onemap::mapping {
namespace {

TEST(RayTable, InvertsTheLens) {
  const hal::Intrinsics k = test::kinect_lens();
  const RayTable rays(k);
  for (int v = 0; v < k.height; v += 13) {
    for (int u = 0; u < k.width; u += 11) {
      const float* ray = rays.row(v) + 2 * u;
      const hal::Point2 back = hal::pixel_of(k, {ray[0], ray[1]});
      EXPECT_NEAR(back.x, u, 1e-3);
      EXPECT_NEAR(back.y, v, 1e-3);
    }
  }
  const Eigen::Vector2d ray = rays.at(200.25, 99.75);
  const hal::Point2 between = hal::pixel_of(k, {ray.x(), ray.y()});
  EXPECT_NEAR(between.x, 200.25, 2e-3);
  EXPECT_NEAR(between.y, 99.75, 2e-3);
  EXPECT_EQ(rays.at(-5, 1000), rays.at(0, k.height - 1));  // outside: the border's ray
}

TEST(ToPoints, FollowsEquationFive) {
  const hal::Intrinsics k;  // no distortion
  const RayTable rays(k);
  std::vector<std::uint16_t> depth(640 * 480, 0);
  depth[10 * 640 + 20] = 10000;  // 2 m
  depth[10 * 640 + 24] = 249;    // under 0.05 m: no measurement
  depth[12 * 640 + 30] = 40001;  // over 8 m
  depth[12 * 640 + 31] = 5000;   // between the strides
  std::vector<Vector3f> out(10);
  ASSERT_EQ(to_points(depth, rays, k.depth_scale, {.stride = 2}, out), 1u);
  EXPECT_NEAR(out[0].x(), (20 - k.cx) / k.fx * 2, 1e-6);
  EXPECT_NEAR(out[0].y(), (10 - k.cy) / k.fy * 2, 1e-6);
  EXPECT_FLOAT_EQ(out[0].z(), 2);
  EXPECT_EQ(to_points(depth, rays, k.depth_scale, {}, out), 2u);
  EXPECT_EQ(to_points(depth, rays, k.depth_scale, {}, std::span(out).first(1)), 1u);
}

TEST(ToPoints, LeavesOutWhatIsFartherThanAsked) {
  const hal::Intrinsics k;
  const RayTable rays(k);
  std::vector<std::uint16_t> depth(640 * 480, 0);
  depth[100] = 25000;  // 5 m
  depth[101] = 25001;
  depth[102] = 40000;  // 8 m
  std::vector<Vector3f> out(10);
  EXPECT_EQ(to_points(depth, rays, k.depth_scale, {.farthest_m = 5}, out), 1u);
  EXPECT_EQ(to_points(depth, rays, k.depth_scale, {.farthest_m = 20}, out), 3u) << "no farther than a measurement is";
}

}  // namespace
}  // namespace onemap::mapping
