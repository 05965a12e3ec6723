#include "hal/backends/openni2/decode.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "hal/backends/openni2/modes.hpp"

// The pure parts of the OpenNI2 backend.
namespace onemap::hal::openni2 {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::vector<std::uint8_t> counting(std::size_t bytes) {
  std::vector<std::uint8_t> out(bytes);
  for (std::size_t i = 0; i < bytes; ++i) out[i] = static_cast<std::uint8_t>(i + 1);
  return out;
}

TEST(OpenNi2Decode, RgbWithPaddedRowsStraightAndMirrored) {
  const auto bytes = counting(2 * 8);  // two rows of two pixels and two bytes of padding
  const imaging::RawImage image{bytes, {2, 2}, 8};
  std::vector<std::uint8_t> rgb(12);
  ASSERT_TRUE(decode_colour(PixelFormat::rgb888, image, false, rgb).ok());
  EXPECT_THAT(rgb, ElementsAre(1, 2, 3, 4, 5, 6, 9, 10, 11, 12, 13, 14));
  ASSERT_TRUE(decode_colour(PixelFormat::rgb888, image, true, rgb).ok());
  EXPECT_THAT(rgb, ElementsAre(4, 5, 6, 1, 2, 3, 12, 13, 14, 9, 10, 11));
}

TEST(OpenNi2Decode, AnOddRowKeepsItsMiddleWhenItIsMirrored) {
  const auto bytes = counting(9);
  std::vector<std::uint8_t> rgb(9);
  ASSERT_TRUE(decode_colour(PixelFormat::rgb888, {bytes, {3, 1}, 0}, true, rgb).ok());
  EXPECT_THAT(rgb, ElementsAre(7, 8, 9, 4, 5, 6, 1, 2, 3));
}

TEST(OpenNi2Decode, DepthStraightAndMirrored) {
  const std::vector<std::uint8_t> bytes{1, 0, 2, 1, 3, 2, 9, 9, 4, 3, 5, 4, 6, 5};  // a row of three and two of padding
  std::vector<std::uint16_t> depth(6);
  ASSERT_TRUE(decode_depth({bytes, {3, 2}, 8}, false, depth).ok());
  EXPECT_THAT(depth, ElementsAre(1, 0x102, 0x203, 0x304, 0x405, 0x506));
  ASSERT_TRUE(decode_depth({bytes, {3, 2}, 8}, true, depth).ok());
  EXPECT_THAT(depth, ElementsAre(0x203, 0x102, 1, 0x506, 0x405, 0x304));
}

TEST(OpenNi2Decode, GreyAndYuvAreColour) {
  std::vector<std::uint8_t> rgb(6);
  const std::vector<std::uint8_t> grey{7, 200};
  ASSERT_TRUE(decode_colour(PixelFormat::grey8, {grey, {2, 1}, 0}, true, rgb).ok());
  EXPECT_THAT(rgb, ElementsAre(200, 200, 200, 7, 7, 7));
  const std::vector<std::uint8_t> uyvy{128, 16, 128, 235}, yuyv{16, 128, 235, 128};
  ASSERT_TRUE(decode_colour(PixelFormat::yuv422, {uyvy, {2, 1}, 0}, false, rgb).ok());
  EXPECT_THAT(rgb, ElementsAre(0, 0, 0, 255, 255, 255));
  ASSERT_TRUE(decode_colour(PixelFormat::yuyv, {yuyv, {2, 1}, 0}, false, rgb).ok());
  EXPECT_THAT(rgb, ElementsAre(0, 0, 0, 255, 255, 255));
}

TEST(OpenNi2Decode, WhatIsTooShortOrNoPictureIsRefused) {
  const auto bytes = counting(11);
  std::vector<std::uint8_t> rgb(12);
  std::vector<std::uint16_t> depth(6);
  EXPECT_FALSE(decode_colour(PixelFormat::rgb888, {bytes, {2, 2}, 0}, false, rgb).ok());
  EXPECT_FALSE(decode_depth({bytes, {3, 2}, 0}, false, depth).ok());
  const Status status = decode_colour(PixelFormat::other, {bytes, {1, 1}, 0}, false, rgb);
  ASSERT_FALSE(status.ok());
  EXPECT_THAT(status.error().reason, HasSubstr("no colour image"));
}

constexpr Mode kDepth{PixelFormat::depth_1_mm, 640, 480, 30}, kFine{PixelFormat::depth_100_um, 640, 480, 30};
constexpr Mode kSmallDepth{PixelFormat::depth_1_mm, 320, 240, 30};
constexpr Mode kRgb{PixelFormat::rgb888, 640, 480, 30}, kSmallRgb{PixelFormat::rgb888, 320, 240, 30};
constexpr Mode kYuv{PixelFormat::yuv422, 640, 480, 30}, kJpeg{PixelFormat::other, 640, 480, 30};
constexpr Mode kBigRgb{PixelFormat::rgb888, 1280, 1024, 15};

TEST(OpenNi2Modes, TheUsualOneIsChosenWhereverItStands) {
  const std::vector depth{kSmallDepth, kFine, kDepth}, colour{kBigRgb, kJpeg, kYuv, kSmallRgb, kRgb};
  const auto chosen = choose_modes(depth, colour, {});
  ASSERT_TRUE(chosen.ok());
  EXPECT_EQ(*chosen, (ModePair{kDepth, kRgb}));
}

TEST(OpenNi2Modes, AWishIsFollowedOrRefusedWithWhatThereIs) {
  const std::vector depth{kDepth, kSmallDepth}, colour{kRgb, kSmallRgb, kBigRgb};
  const auto small = choose_modes(depth, colour, parse_mode("320x240@30"));
  ASSERT_TRUE(small.ok());
  EXPECT_EQ(*small, (ModePair{kSmallDepth, kSmallRgb}));
  const auto none = choose_modes(depth, colour, parse_mode("1280x1024@15"));
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().reason,
            "there is no mode 1280x1024@15; depth has 640x480@30 1 mm, 320x240@30 1 mm; colour has 640x480@30 RGB, "
            "320x240@30 RGB, 1280x1024@15 RGB");
}

TEST(OpenNi2Modes, WithoutTheUsualOneTheFirstInCommonAndElseNone) {
  const std::vector depth{kFine, kSmallDepth}, colour{kJpeg, kSmallRgb};
  const auto common = choose_modes(depth, colour, {});
  ASSERT_TRUE(common.ok());
  EXPECT_EQ(*common, (ModePair{kSmallDepth, kSmallRgb}));
  const auto none = choose_modes(std::vector{kSmallDepth}, std::vector{kRgb}, {});
  ASSERT_FALSE(none.ok());
  EXPECT_THAT(none.error().reason, HasSubstr("in common"));
  EXPECT_FALSE(choose_modes({}, {}, {}).ok());
}

TEST(OpenNi2Modes, ParsesWidthHeightAndRate) {
  EXPECT_EQ(parse_mode("848x480@60"), (Mode{PixelFormat::other, 848, 480, 60}));
  for (const char* wrong : {"", "640", "640x480", "640x480@", "x480@30", "640x480@30 ", "0x480@30", "640*480@30",
                            "-640x480@30", "99999999999x480@30"})
    EXPECT_EQ(parse_mode(wrong), std::nullopt) << wrong;
}

}  // namespace
}  // namespace onemap::hal::openni2
