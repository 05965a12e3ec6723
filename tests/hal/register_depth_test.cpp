#include "hal/imaging/register_depth.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "hal/imaging/image_size.hpp"
#include "hal/lens.hpp"
#include "support/random.hpp"

namespace onemap::hal::imaging {
namespace {

using Depth = std::vector<std::uint16_t>;

Intrinsics camera(int width, int height, double focal) {
  Intrinsics k;
  k.width = width;
  k.height = height;
  k.fx = k.fy = focal;
  k.cx = (width - 1) / 2.0;
  k.cy = (height - 1) / 2.0;
  k.depth_scale = 1000;
  return k;
}

Depth registered(const Intrinsics& depth, const Intrinsics& colour, const ColourFromDepth& pose, const Depth& in,
                 DepthRegistration::Counts* counts = nullptr) {
  Depth out(size_of(colour).pixels(), 77);
  const auto found = DepthRegistration(depth, colour, pose).apply(in, out);
  if (counts) *counts = found;
  return out;
}

TEST(RegisterDepth, CamerasInOnePlaceChangeNothing) {
  const Intrinsics k = camera(40, 30, 33);
  test::Random random(1);
  Depth in(1200);
  for (auto& d : in) d = random.next() % 4 == 0 ? 0 : static_cast<std::uint16_t>(random.integer(300, 5000));
  EXPECT_EQ(registered(k, k, {}, in), in);
  Intrinsics lens = k;
  lens.k1 = 0.1, lens.k2 = -0.05, lens.p1 = 0.001;
  EXPECT_EQ(registered(lens, lens, {}, in), in);
}

TEST(RegisterDepth, AFinerColourImageHasNoHolesAndTheUnitChanges) {
  const Intrinsics k = camera(40, 30, 33);
  Intrinsics fine = camera(120, 90, 99);
  fine.depth_scale = 5000;
  const Depth out = registered(k, fine, {}, Depth(1200, 1500));
  EXPECT_TRUE(std::ranges::all_of(out, [](auto v) { return v == 7500; }));
}

// A wall at 2 m with a box at 1 m before its middle, seen from two places 5 cm apart: each pixel of the colour image
// must show what a ray through it meets first, or nothing where the depth camera did not see that.
TEST(RegisterDepth, WhatIsHiddenFromTheColourCameraGivesNoDepth) {
  const Intrinsics k = camera(160, 120, 130);
  const ColourFromDepth pose{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {-0.05, 0, 0}};  // the colour camera is 5 cm to the right
  const double half_box_m = 0.2;
  const auto sees_box = [&](double u, double eye_x) { return std::abs(eye_x + (u - k.cx) / k.fx * 1.0) <= half_box_m; };
  Depth in(size_of(k).pixels());
  for (int v = 0; v < k.height; ++v)
    for (int u = 0; u < k.width; ++u) in[static_cast<std::size_t>(v * k.width + u)] = sees_box(u, 0) ? 1000 : 2000;
  DepthRegistration::Counts counts;
  const Depth out = registered(k, k, pose, in, &counts);
  EXPECT_EQ(counts.readings, in.size());
  EXPECT_GT(counts.outside, 0u);
  int box = 0, wall = 0, none = 0;
  for (int u = 0; u < k.width; ++u) {
    const std::uint16_t value = out[static_cast<std::size_t>(60 * k.width + u)];
    const bool edge = sees_box(u - 1, 0.05) != sees_box(u + 1, 0.05);  // a pixel at the box's side may be either
    if (value == 1000) ++box;
    if (value == 2000) ++wall;
    if (value == 0) ++none;
    if (value != 0 && !edge) {
      EXPECT_EQ(value, sees_box(u, 0.05) ? 1000 : 2000) << u;
    }
  }
  EXPECT_NEAR(box, 52, 2);      // 0.4 m at 1 m
  EXPECT_NEAR(none, 3 + 3, 3);  // the wall behind the box's side, and the image's side that only colour sees
  EXPECT_EQ(box + wall + none, k.width);
}

// Point by point, in double: each reading's middle moves to one pixel. What we fill there is that depth or something
// nearer.
TEST(RegisterDepth, AgreesWithMovingPointByPoint) {
  Intrinsics depth = camera(64, 48, 60), colour = camera(80, 60, 70);
  depth.k1 = -0.08;
  colour.k1 = 0.12, colour.k2 = -0.2, colour.p1 = 0.002, colour.p2 = -0.001;
  const double angle = 0.03, c = std::cos(angle), s = std::sin(angle);
  const ColourFromDepth pose{{c, 0, s, 0, 1, 0, -s, 0, c}, {0.025, -0.002, 0.001}};
  Depth in(size_of(depth).pixels());
  for (std::size_t i = 0; i < in.size(); ++i)  // a slanted wall
    in[i] = static_cast<std::uint16_t>(1000 + 10 * (i % 64) + 5 * (i / 64));
  const Depth out = registered(depth, colour, pose, in);
  int inside = 0;
  for (int v = 0; v < depth.height; ++v)
    for (int u = 0; u < depth.width; ++u) {
      const double z = in[static_cast<std::size_t>(v * depth.width + u)] / 1000.0;
      const Point2 ray = ray_of(depth, {double(u), double(v)});
      const double p[] = {ray.x * z, ray.y * z, z};
      double q[3];
      for (std::size_t i = 0; i < 3; ++i)
        q[i] = pose.rotation[3 * i] * p[0] + pose.rotation[3 * i + 1] * p[1] + pose.rotation[3 * i + 2] * p[2] +
               pose.translation_m[i];
      const Point2 pixel = pixel_of(colour, {q[0] / q[2], q[1] / q[2]});
      const long x = std::lround(pixel.x), y = std::lround(pixel.y);
      if (x < 1 || y < 1 || x > colour.width - 2 || y > colour.height - 2) continue;
      ++inside;
      const std::uint16_t value = out[static_cast<std::size_t>(y * colour.width + x)];
      ASSERT_GT(value, 0) << u << ", " << v;
      ASSERT_NEAR(value, 1000 * q[2], 16) << u << ", " << v;  // a neighbour's, at most
    }
  EXPECT_GT(inside, 2000);
}

TEST(RegisterDepth, AnyDepthAndAnyPoseHaveAnAnswerInTime) {
  const Intrinsics k = camera(64, 48, 60);
  test::Random random(5);
  Depth in(size_of(k).pixels());
  for (int round = 0; round < 30; ++round) {
    for (auto& d : in) d = static_cast<std::uint16_t>(random.next());
    ColourFromDepth pose;
    for (double& r : pose.rotation) r = random.uniform(-1, 1);
    for (double& t : pose.translation_m) t = random.uniform(-0.1, 0.1);
    Intrinsics lens = k;
    lens.k1 = random.uniform(-1, 1), lens.k3 = random.uniform(-5, 5);
    DepthRegistration::Counts counts;
    registered(lens, lens, pose, in, &counts);
    EXPECT_LE(counts.outside, counts.readings);
  }
}

}  // namespace
}  // namespace onemap::hal::imaging
