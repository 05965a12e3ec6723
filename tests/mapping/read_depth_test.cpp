// A depth image's units become metres, through a look-up table or without.
#include "local/read_depth.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "mapping/local/depth_range.hpp"
#include "support/random.hpp"

namespace onemap::mapping {
namespace {

constexpr DepthUnits kMillimetres{0.001f, 4.f};

TEST(ReadDepth, WhatIsTooNearOrTooFarIsNotToBeFused) {
  const std::vector<std::uint16_t> depth{0, 40, 1000, 4000, 4001, 6000, 65535};
  ASSERT_GT(kMinDepth_m, 0.04f);
  ASSERT_LT(kMaxDepth_m, 65.f);
  std::vector<float> out(depth.size());
  read_depth(depth, kMillimetres, out.data());
  EXPECT_EQ(out[0], 0);
  EXPECT_EQ(out[1], 0) << "nearer than any sensor measures";
  EXPECT_EQ(out[2], 0.001f * 1000);
  EXPECT_EQ(out[3], 0.001f * 4000);
  EXPECT_EQ(out[4], -0.001f * 4001) << "smoothing asks it all the same";
  EXPECT_EQ(out[5], -0.001f * 6000);
  EXPECT_EQ(out[6], 0);
}

// The last pixel, too, behind which nothing may be read, and whatever is left over of eights.
TEST(ReadDepth, BothTwinsGiveTheSameBytes) {
  test::Random random(5);
  for (const std::size_t pixels : {1u, 2u, 3u, 700u}) {
    std::vector<std::uint16_t> depth(pixels);
    for (auto& reading : depth) reading = static_cast<std::uint16_t>(random.below(9000));
    std::vector<std::int32_t> source(1003);
    for (auto& from : source)
      from = static_cast<std::int32_t>(random.below(static_cast<std::uint32_t>(pixels) + 1)) - 1;
    source[4] = static_cast<std::int32_t>(pixels) - 1;
    std::vector<float> plain(source.size(), 9.f), simd = plain, in_place(pixels);
    look_up_depth(depth, source, kMillimetres, false, plain.data());
    look_up_depth(depth, source, kMillimetres, true, simd.data());
    EXPECT_EQ(plain, simd);
    read_depth(depth, kMillimetres, in_place.data());
    for (std::size_t i = 0; i < source.size(); ++i)
      EXPECT_EQ(plain[i], source[i] < 0 ? 0 : in_place[static_cast<std::size_t>(source[i])]);
  }
}

}  // namespace
}  // namespace onemap::mapping
