#include "hal/imaging/register_depth.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "footprints.hpp"
#include "hal/base/twin.hpp"
#include "hal/imaging/image_size.hpp"
#include "hal/lens.hpp"
#include "nearest.hpp"
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

// What the fast one computes, reading by reading and pixel by pixel, in the same single precision.
Depth slowly(const Intrinsics& depth, const Intrinsics& colour, const ColourFromDepth& pose, const Depth& in,
             DepthRegistration::Counts& counts) {
  const auto f = [](double value) { return static_cast<float>(value); };
  const auto& r = pose.rotation;
  Depth out(size_of(colour).pixels(), 0);
  for (std::size_t i = 0; i < in.size(); ++i) {
    if (in[i] == 0) continue;
    ++counts.readings;
    const auto columns = static_cast<std::size_t>(depth.width);
    const Point2 ray = ray_of(depth, {double(i % columns), double(i / columns)});
    const float z_m = float(in[i]) * f(1 / depth.depth_scale) + 0.0f;
    float q[3];
    for (std::size_t k = 0; k < 3; ++k)
      q[k] = f(r[3 * k] * ray.x + r[3 * k + 1] * ray.y + r[3 * k + 2]) * z_m + f(pose.translation_m[k]);
    const float inverse = 1 / std::max(q[2], 0.01f), x = q[0] * inverse, y = q[1] * inverse;
    float u = x, v = y;
    if (has_distortion(colour)) {
      const float r2 = x * x + y * y, p1 = f(colour.p1), p2 = f(colour.p2);
      const float grown = 1 + r2 * (f(colour.k1) + r2 * (f(colour.k2) + r2 * f(colour.k3)));
      u = x * grown + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
      v = y * grown + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
    }
    u = f(colour.fx) * u + f(colour.cx);
    v = f(colour.fy) * v + f(colour.cy);
    const float half_u = 0.5f * f(colour.fx / depth.fx) * (z_m * inverse) + 0.1f;
    const float half_v = 0.5f * f(colour.fy / depth.fy) * (z_m * inverse) + 0.1f;
    const int value = static_cast<int>(q[2] * f(colour.depth_scale) + 0.5f);
    bool any = false;
    if (q[2] > 0.01f && value >= 11 && value <= 65535)
      for (int row = 0; row < colour.height; ++row)
        for (int column = 0; column < colour.width; ++column) {
          const bool covered = float(column) >= u - half_u && float(column) < u + half_u && float(row) >= v - half_v &&
                               float(row) < v + half_v;
          if (!covered) continue;
          any = true;
          std::uint16_t& pixel = out[static_cast<std::size_t>(row * colour.width + column)];
          if (pixel == 0 || value < pixel) pixel = static_cast<std::uint16_t>(value);
        }
    counts.outside += any ? 0 : 1;
  }
  return out;
}

struct Rig {
  Intrinsics depth, colour;
  ColourFromDepth pose;
};

// Cameras a hand's breadth apart, of other sizes and lenses, and an image of walls, steps, noise and nothing.
std::vector<Rig> rigs() {
  std::vector<Rig> out;
  test::Random random(11);
  for (const double finer : {1.0, 0.6, 1.5, 2.4}) {
    for (const bool lens : {false, true}) {
      Rig rig{camera(53, 30, 47), camera(static_cast<int>(53 * finer), static_cast<int>(30 * finer), 47 * finer), {}};
      const double angle = random.uniform(-0.05, 0.05), c = std::cos(angle), s = std::sin(angle);
      rig.pose = {{c, 0, s, 0, 1, 0, -s, 0, c}, {random.uniform(-0.1, 0.1), random.uniform(-0.02, 0.02), 0.01}};
      if (lens) rig.colour.k1 = 0.12, rig.colour.k2 = -0.2, rig.colour.p1 = 0.002, rig.depth.k1 = -0.08;
      out.push_back(rig);
    }
  }
  return out;
}

Depth walls(const Intrinsics& k, std::uint64_t seed) {
  test::Random random(seed);
  Depth in(size_of(k).pixels());
  for (std::size_t i = 0; i < in.size(); ++i) {
    const std::size_t u = i % static_cast<std::size_t>(k.width);
    in[i] = static_cast<std::uint16_t>((u < 20 ? 1500 : 700 + 10 * u) + random.next() % 5);
    if (random.next() % 16 == 0) in[i] = static_cast<std::uint16_t>(random.next());
    if (u > 40 && u < 45) in[i] = 0;
  }
  return in;
}

TEST(RegisterDepth, IsWhatTheSlowOneComputesToTheByte) {
  for (const Rig& rig : rigs()) {
    const Depth in = walls(rig.depth, 3);
    DepthRegistration::Counts counts, expected;
    const Depth out = registered(rig.depth, rig.colour, rig.pose, in, &counts);
    const Depth reference = slowly(rig.depth, rig.colour, rig.pose, in, expected);
    EXPECT_GT(std::ranges::count_if(out, [](auto v) { return v != 0; }), 100);
    EXPECT_EQ(out, reference) << rig.colour.width << " columns, lens " << rig.colour.k1;
    EXPECT_EQ(counts.readings, expected.readings);
    EXPECT_EQ(counts.outside, expected.outside);
  }
}

// Rows above and below what colour sees are left out: a narrow lens, up and down, near and far, tilted.
TEST(RegisterDepth, RowsBesideTheColourImageAreLeftOutAndNothingElse) {
  test::Random random(29);
  std::uint64_t outside = 0, readings = 0;
  for (int round = 0; round < 40; ++round) {
    const Intrinsics depth = camera(53, 60, 47), colour = camera(53, 30, random.uniform(60, 140));
    const double angle = random.uniform(-0.4, 0.4), c = std::cos(angle), s = std::sin(angle);
    const ColourFromDepth pose{
        {1, 0, 0, 0, c, -s, 0, s, c},
        {random.uniform(-0.05, 0.05), round % 3 == 0 ? 0 : random.uniform(-0.05, 0.05), random.uniform(-0.05, 0.05)}};
    const Depth in = walls(depth, static_cast<std::uint64_t>(round));
    DepthRegistration::Counts counts, expected;
    const Depth out = registered(depth, colour, pose, in, &counts);
    ASSERT_EQ(out, slowly(depth, colour, pose, in, expected)) << round;
    ASSERT_EQ(counts.readings, expected.readings);
    ASSERT_EQ(counts.outside, expected.outside);
    outside += counts.outside, readings += counts.readings;
  }
  EXPECT_GT(2 * outside, readings);
}

// Walls, so that neighbours lie beside each other; then what a turned camera sees, where they do not.
TEST(RegisterDepth, TheTwinsKeepTheSame) {
  if (!simd_available()) GTEST_SKIP() << "this CPU has no AVX2";
  test::Random random(23);
  constexpr std::size_t kColumns = 90, kRows = 40;
  for (int round = 0; round < 200; ++round) {
    footprints::Covered row(3 + random.next() % 60);
    const std::size_t step = round % 3 == 0 ? 0 : 1;
    std::size_t wide = 1, high = 1, place = random.next() % (kColumns * 30);
    for (std::size_t i = 0; i < row.first.size(); ++i) {
      if (random.next() % 12 == 0) wide = 1 + random.next() % 3, high = 1 + random.next() % 3;
      if (random.next() % 12 == 0) place = random.next() % (kColumns * 30);
      row.first[i] = random.next() % 20 == 0 ? footprints::kNowhere : static_cast<std::int32_t>(place);
      row.size[i] = static_cast<std::uint16_t>(wide | high << 8);
      row.less_1[i] = static_cast<std::uint16_t>(random.next());
      place += step;
    }
    Depth plain(kColumns * kRows, nearest::kNothing), simd = plain;
    nearest::keep_plain(row, kColumns, plain.data());
    nearest::keep_simd(row, kColumns, simd.data());
    ASSERT_EQ(plain, simd) << round;
  }
}

TEST(RegisterDepth, TheTwinsFindTheSamePixels) {
  if (!simd_available()) GTEST_SKIP() << "this CPU has no AVX2";
  test::Random random(17);
  const auto any = [&] { return static_cast<float>(random.uniform(-2, 2)); };
  for (int round = 0; round < 200; ++round) {
    Intrinsics colour = camera(101, 77, 90);
    if (round % 2 == 0) colour.k1 = any(), colour.p2 = any() / 10;
    const footprints::Rig rig{footprints::ColourLens(colour),
                              {any(), any(), any()},
                              0.001f,
                              0.01f,
                              1000,
                              1.5f,
                              1.4f,
                              0.01f,
                              65536,
                              11,
                              colour.width,
                              colour.height};
    const std::size_t width = 1 + random.next() % 70;
    Depth depth(width);
    std::vector<float> x(width), y(width), z(width);
    for (std::size_t i = 0; i < width; ++i) {
      depth[i] = random.next() % 8 == 0 ? 0 : static_cast<std::uint16_t>(random.next());
      x[i] = any(), y[i] = any(), z[i] = any();
    }
    if (round % 10 == 0) x[0] = z[width - 1] = std::nanf("");
    footprints::Covered plain(width), simd(width);
    footprints::find_plain(rig, {depth, x.data(), y.data(), z.data()}, plain);
    footprints::find_simd(rig, {depth, x.data(), y.data(), z.data()}, simd);
    EXPECT_EQ(plain.first, simd.first);
    EXPECT_EQ(plain.size, simd.size);
    EXPECT_EQ(plain.less_1, simd.less_1);
    EXPECT_EQ(plain.readings, simd.readings);
    EXPECT_EQ(plain.seen, simd.seen);
  }
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
