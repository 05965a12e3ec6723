#include "hal/imaging/encode_image.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hal/base/splitmix.hpp"
#include "hal/imaging/image_file.hpp"

namespace onemap::hal::imaging {
namespace {

TEST(EncodeImage, WhatIsEncodedIsDecodedAgain) {
  SplitMix random(3);
  for (const ImageSize size : {ImageSize{1, 1}, ImageSize{40, 30}, ImageSize{17, 5}}) {
    std::vector<std::uint8_t> rgb(3 * size.pixels()), rgb_back(rgb.size()), file{1, 2, 3};
    std::vector<std::uint16_t> depth(size.pixels()), depth_back(depth.size());
    for (auto& v : rgb) v = static_cast<std::uint8_t>(random.next());
    for (auto& v : depth) v = static_cast<std::uint16_t>(random.next());
    ASSERT_TRUE(encode_colour(size, rgb, file));
    ASSERT_TRUE(decode_color(file, size, rgb_back));
    EXPECT_EQ(rgb_back, rgb);
    const auto once = file;
    ASSERT_TRUE(encode_colour(size, rgb, file));
    EXPECT_EQ(file, once) << "the same pixels give the same bytes";
    ASSERT_TRUE(encode_depth(size, depth, file));
    ASSERT_TRUE(decode_depth(file, size, depth_back));
    EXPECT_EQ(depth_back, depth);
  }
}

TEST(EncodeImage, AJpegLooksLikeThePicture) {
  constexpr ImageSize kSize{48, 32};
  std::vector<std::uint8_t> rgb(3 * kSize.pixels()), back(rgb.size()), file{9};
  for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = static_cast<std::uint8_t>(40 + i / 3 % 48 * 3 + i % 3 * 20);
  ASSERT_TRUE(encode_jpeg(kSize, rgb, 90, file));
  ASSERT_TRUE(decode_color(file, kSize, back));
  for (std::size_t i = 0; i < rgb.size(); ++i) ASSERT_NEAR(rgb[i], back[i], 12) << i;
  const auto once = file;
  ASSERT_TRUE(encode_jpeg(kSize, rgb, 90, file));
  EXPECT_EQ(file, once);
  EXPECT_FALSE(encode_jpeg({48, 33}, rgb, 90, file));
}

TEST(EncodeImage, PixelsThatDoNotFitTheSizeAreRefused) {
  std::vector<std::uint8_t> file;
  const std::vector<std::uint8_t> rgb(11);
  const std::vector<std::uint16_t> depth(4);
  EXPECT_THAT(encode_colour({2, 2}, rgb, file).error().reason, testing::HasSubstr("not as many pixels"));
  EXPECT_FALSE(encode_depth({2, 3}, depth, file));
  EXPECT_FALSE(encode_depth({0, 0}, {}, file));
  EXPECT_FALSE(encode_depth({kMostSide_px + 1, 1}, {}, file));
}

}  // namespace
}  // namespace onemap::hal::imaging
