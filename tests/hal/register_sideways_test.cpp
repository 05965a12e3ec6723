// Two pinholes beside each other that look the same way: DepthRegistration's short way, beside a slow one that looks at
// every pixel of the colour image.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "by_lines.hpp"
#include "hal/base/twin.hpp"
#include "hal/imaging/image_size.hpp"
#include "hal/imaging/register_depth.hpp"
#include "sideways.hpp"
#include "support/random.hpp"

namespace onemap::hal::imaging {
namespace {

struct Pinholes {
  Intrinsics depth, colour;
  ColourFromDepth pose;
  double offset_m = 0;
};

Intrinsics pinhole(int width, int height, double focal, double scale) {
  Intrinsics k;
  k.width = width, k.height = height;
  k.fx = k.fy = focal;
  k.cx = (width - 1) / 2.0 + 1.3, k.cy = (height - 1) / 2.0 - 0.8;
  k.depth_scale = scale;
  return k;
}

// Coarser and finer colour lenses, in both directions, with readings of which a few are anything.
std::vector<Pinholes> pinholes() {
  std::vector<Pinholes> out;
  for (const double finer : {0.6, 0.905, 1.0, 1.6, 2.2, 3.4})
    for (const double right_m : {-0.025, 0.0, 0.06})
      out.push_back({pinhole(71, 33, 50, 1000),
                     pinhole(static_cast<int>(60 * finer), static_cast<int>(36 * finer), 50 * finer, 5000),
                     {.translation_m = {right_m, 0, 0}},
                     right_m / 3});
  return out;
}

std::vector<std::uint16_t> readings(const Intrinsics& k, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<std::uint16_t> in(size_of(k).pixels());
  for (std::size_t i = 0; i < in.size(); ++i) {
    in[i] = static_cast<std::uint16_t>(i % 71 < 30 ? 1200 + i % 7 : 2500 - 9 * (i % 71));
    if (random.next() % 9 == 0) in[i] = 0;
    if (random.next() % 25 == 0) in[i] = static_cast<std::uint16_t>(random.next());
  }
  return in;
}

std::vector<std::uint16_t> looked_at_slowly(const Pinholes& of, const std::vector<std::uint16_t>& in,
                                            std::uint64_t& outside) {
  const auto f = [](double value) { return static_cast<float>(value); };
  std::vector<std::uint16_t> out(size_of(of.colour).pixels(), 0);
  for (std::size_t i = 0; i < in.size(); ++i) {
    if (in[i] == 0) continue;
    const auto columns = static_cast<std::size_t>(of.depth.width);
    const float z = float(in[i]) * f(1 / of.depth.depth_scale) + f(of.offset_m);
    const float shift = f(of.colour.fx) * f(of.pose.translation_m[0]) / std::max(z, 0.01f);
    const float u = f(of.colour.fx) * f((double(i % columns) - of.depth.cx) / of.depth.fx) + f(of.colour.cx) + shift;
    const float v = f(of.colour.fy) * f((double(i / columns) - of.depth.cy) / of.depth.fy) + f(of.colour.cy);
    const float half = 0.5f * f(of.colour.fx / of.depth.fx) + 0.1f;
    const auto value = static_cast<std::int64_t>(std::max(0.0f, z * f(of.colour.depth_scale) + 0.5f));
    bool any = false;
    for (int row = 0; row < of.colour.height; ++row)
      for (int column = 0; column < of.colour.width; ++column) {
        const bool beside = float(column) < u - half || float(column) >= u + half;
        if (beside || float(row) < v - half || float(row) >= v + half || value < 51 || value > 65535) continue;
        any = true;
        std::uint16_t& pixel = out[static_cast<std::size_t>(row * of.colour.width + column)];
        if (pixel == 0 || value < pixel) pixel = static_cast<std::uint16_t>(value);
      }
    outside += any ? 0 : 1;
  }
  return out;
}

TEST(RegisterSideways, IsWhatTheSlowOneSeesToTheByte) {
  for (const Pinholes& of : pinholes()) {
    ASSERT_TRUE(ByLines::suits(of.depth, of.colour, of.pose));
    const auto in = readings(of.depth, 5);
    std::vector<std::uint16_t> out(size_of(of.colour).pixels(), 77);
    const auto counts = DepthRegistration(of.depth, of.colour, of.pose, of.offset_m).apply(in, out);
    std::uint64_t outside = 0;
    const auto slow = looked_at_slowly(of, in, outside);
    const auto empty = std::ranges::count(slow, 0);
    EXPECT_EQ(out, slow) << of.colour.width << " columns, " << of.pose.translation_m[0] << " m";
    EXPECT_LT(2 * empty, static_cast<std::ptrdiff_t>(slow.size()));
    EXPECT_EQ(counts.readings, in.size() - static_cast<std::size_t>(std::ranges::count(in, 0)));
    EXPECT_EQ(counts.outside, outside);
  }
}

// The short way and the long one differ where a footprint's side falls on a pixel's middle, by the last bits.
TEST(RegisterSideways, IsTheLongWaysAnswerButForItsLastBits) {
  for (const Pinholes& of : pinholes()) {
    const auto in = readings(of.depth, 6);
    std::vector<std::uint16_t> here(size_of(of.colour).pixels()), there = here;
    DepthRegistration(of.depth, of.colour, of.pose).apply(in, here);
    ColourFromDepth almost = of.pose;
    almost.translation_m[1] = 1e-9;
    ASSERT_FALSE(ByLines::suits(of.depth, of.colour, almost));
    DepthRegistration(of.depth, of.colour, almost).apply(in, there);
    std::size_t other = 0;
    for (std::size_t i = 0; i < here.size(); ++i) other += here[i] != there[i];
    EXPECT_LT(100 * other, here.size()) << of.colour.width;
  }
}

TEST(RegisterSideways, LensesThatBendAndTurnDoNotSuit) {
  const Intrinsics k = pinhole(64, 48, 60, 1000);
  EXPECT_TRUE(ByLines::suits(k, k, {}));
  Intrinsics bent = k;
  bent.k1 = 0.01;
  EXPECT_FALSE(ByLines::suits(bent, k, {}));
  EXPECT_FALSE(ByLines::suits(k, bent, {}));
  EXPECT_FALSE(ByLines::suits(k, k, {.translation_m = {0.02, 0.001, 0}}));
  EXPECT_FALSE(ByLines::suits(k, k, {.translation_m = {0.02, 0, 0.001}}));
  EXPECT_FALSE(ByLines::suits(k, k, {{1, 0, 0, 0, 1, 1e-4, 0, -1e-4, 1}, {}}));
}

TEST(RegisterSideways, TheTwinsAreEqual) {
  if (!simd_available()) GTEST_SKIP() << "this CPU has no AVX2";
  test::Random random(7);
  for (std::size_t width = 1; width < 70; ++width) {
    sideways::Rig rig{{},    0.001f, 0.01f, static_cast<float>(random.uniform(-20, 20)), 0.65f, 1000, 0.01f,
                      65536, 11,     61};
    std::vector<std::uint16_t> depth(width);
    for (std::size_t i = 0; i < width; ++i) {
      rig.column.push_back(static_cast<float>(random.uniform(-10, 71)));
      depth[i] = random.next() % 8 == 0 ? 0 : static_cast<std::uint16_t>(random.next());
    }
    if (width % 10 == 0) rig.column[0] = std::numeric_limits<float>::quiet_NaN();
    sideways::Covered plain(width), simd(width);
    sideways::find_plain(rig, depth, plain);
    sideways::find_simd(rig, depth, simd);
    EXPECT_EQ(plain.first, simd.first);
    EXPECT_EQ(plain.wide, simd.wide);
    EXPECT_EQ(plain.less_1, simd.less_1);
    EXPECT_EQ(plain.readings, simd.readings);
    EXPECT_EQ(plain.seen, simd.seen);
    for (std::size_t i = 0; i < width; ++i) EXPECT_LE(plain.first[i] + plain.wide[i], rig.columns) << "in the image";
    std::vector<std::uint16_t> line(61, 65535), other(61, 65535);
    sideways::keep(plain, 2, line.data());
    sideways::merge_plain(depth.data(), width < 61 ? width : 61, line.data());
    sideways::keep(plain, 9, other.data());
    sideways::merge_simd(depth.data(), width < 61 ? width : 61, other.data());
    EXPECT_EQ(line, other);
  }
}

}  // namespace
}  // namespace onemap::hal::imaging
