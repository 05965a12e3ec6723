#include "hal/imaging/image_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "hal/encoded_images.hpp"

namespace onemap::hal::imaging {
namespace {

using test::Bytes;
using test::PngKind;
using testing::HasSubstr;

constexpr ImageSize kImageSize{40, 30};
constexpr std::size_t kPixels = 40 * 30;

// The decoded pixels, or the test fails with the reason.
Bytes color_of(const Bytes& file) {
  Bytes rgb(3 * kPixels);
  const Status status = decode_color(file, kImageSize, rgb);
  EXPECT_TRUE(status.ok()) << status.error().text();
  return rgb;
}

std::string color_error(const Bytes& file) {
  Bytes rgb(3 * kPixels);
  const Status status = decode_color(file, kImageSize, rgb);
  return status ? "" : status.error().reason;
}

std::string depth_error(const Bytes& file) {
  std::vector<std::uint16_t> depth(kPixels);
  const Status status = decode_depth(file, kImageSize, depth);
  return status ? "" : status.error().reason;
}

Bytes grey_picture() {
  Bytes grey;
  for (std::size_t i = 0; i < kPixels; ++i) grey.push_back(static_cast<std::uint8_t>(i * 7));
  return grey;
}

Bytes tripled(const Bytes& grey) {
  Bytes rgb;
  for (const std::uint8_t g : grey) rgb.insert(rgb.end(), {g, g, g});
  return rgb;
}

TEST(ImageFile, RgbPngIsExactPlainAndInterlaced) {
  const Bytes picture = test::picture(40, 30, 5);
  EXPECT_EQ(color_of(test::encode_png(40, 30, {}, picture)), picture);
  EXPECT_EQ(color_of(test::encode_png(40, 30, {PNG_COLOR_TYPE_RGB, 8, PNG_INTERLACE_ADAM7}, picture)), picture);
}

TEST(ImageFile, GreyPngIsExpanded) {
  EXPECT_EQ(color_of(test::encode_png(40, 30, {PNG_COLOR_TYPE_GRAY, 8}, grey_picture())), tripled(grey_picture()));
}

TEST(ImageFile, OneBitGreyPngIsBlackAndWhite) {
  const Bytes rows(5 * 30, 0xA5);  // 1010 0101 in each byte
  Bytes expected;
  for (std::size_t i = 0; i < kPixels; ++i)
    expected.insert(expected.end(), 3, (0xA5 >> (7 - i % 8)) & 1 ? std::uint8_t{255} : std::uint8_t{0});
  EXPECT_EQ(color_of(test::encode_png(40, 30, {PNG_COLOR_TYPE_GRAY, 1}, rows)), expected);
}

TEST(ImageFile, AlphaIsDropped) {
  const Bytes picture = test::picture(40, 30, 9);
  Bytes rgba;
  for (std::size_t i = 0; i < kPixels; ++i) {
    rgba.insert(rgba.end(), picture.begin() + static_cast<std::ptrdiff_t>(3 * i),
                picture.begin() + static_cast<std::ptrdiff_t>(3 * i + 3));
    rgba.push_back(static_cast<std::uint8_t>(i));
  }
  EXPECT_EQ(color_of(test::encode_png(40, 30, {PNG_COLOR_TYPE_RGB_ALPHA, 8}, rgba)), picture);
}

TEST(ImageFile, SixteenBitColorKeepsTheHighByte) {
  const Bytes picture = test::picture(40, 30, 1);
  Bytes rows;
  for (const std::uint8_t value : picture) rows.insert(rows.end(), {value, 0x77});
  EXPECT_EQ(color_of(test::encode_png(40, 30, {PNG_COLOR_TYPE_RGB, 16}, rows)), picture);
}

TEST(ImageFile, PaletteIsLookedUp) {
  Bytes rows, expected;
  for (std::size_t i = 0; i < kPixels; ++i) {
    const int entry = static_cast<int>(i % 128);
    rows.push_back(static_cast<std::uint8_t>(entry));
    for (const int value : {entry, 2 * entry, 255 - entry}) expected.push_back(static_cast<std::uint8_t>(value));
  }
  EXPECT_EQ(color_of(test::encode_png(40, 30, {PNG_COLOR_TYPE_PALETTE, 8}, rows)), expected);
}

TEST(ImageFile, JpegIsNearThePicture) {
  const Bytes smooth = [] {
    Bytes rgb;
    for (int i = 0; i < 40 * 30; ++i) rgb.insert(rgb.end(), {200, static_cast<std::uint8_t>(i % 40 * 4), 60});
    return rgb;
  }();
  const Bytes decoded = color_of(test::encode_jpeg(40, 30, 3, smooth));
  for (std::size_t i = 0; i < smooth.size(); ++i) ASSERT_NEAR(decoded[i], smooth[i], 12) << "byte " << i;
}

TEST(ImageFile, PlainChromaIsNearSmoothChromaAndHasItsLuma) {
  const auto size = ImageSize{40, 30};
  const Bytes jpeg = test::encode_jpeg(40, 30, 3, test::picture(40, 30, 5));
  Bytes smooth(3 * kPixels), plain(3 * kPixels);
  ASSERT_TRUE(decode_color(jpeg, size, smooth).ok());
  ASSERT_TRUE(decode_color(jpeg, size, plain, Chroma::plain).ok());
  EXPECT_NE(plain, smooth);
  const auto luma = [](const Bytes& rgb, std::size_t i) {
    return 0.299 * rgb[3 * i] + 0.587 * rgb[3 * i + 1] + 0.114 * rgb[3 * i + 2];
  };
  double off = 0;
  for (std::size_t i = 0; i < kPixels; ++i) off += std::abs(luma(plain, i) - luma(smooth, i));
  EXPECT_LT(off / kPixels, 2) << "what is tracked is the same";
}

TEST(ImageFile, GreyJpegIsExpanded) {
  const Bytes decoded = color_of(test::encode_jpeg(40, 30, 1, Bytes(kPixels, 99)));
  EXPECT_EQ(decoded, Bytes(3 * kPixels, 99));
}

TEST(ImageFile, MotionJpegHasTheStandardTables) {
  const Bytes jpeg = test::encode_jpeg(40, 30, 3, test::picture(40, 30, 5));
  Bytes motion = test::without_huffman_tables(jpeg);
  ASSERT_LT(motion.size(), jpeg.size() - 300);
  EXPECT_EQ(color_of(motion), color_of(jpeg));
  motion.insert(motion.end(), 500, 0);  // cameras fill their buffers up
  EXPECT_EQ(color_of(motion), color_of(jpeg));
}

TEST(ImageFile, DepthValuesAreExact) {
  const std::vector<std::uint16_t> depth = test::ramp(40, 30, 3);
  std::vector<std::uint16_t> decoded(kPixels);
  ASSERT_TRUE(decode_depth(test::encode_depth_png(40, 30, depth), kImageSize, decoded).ok());
  EXPECT_EQ(decoded, depth);
}

TEST(ImageFile, EveryTruncationIsAnError) {
  const std::vector<std::pair<const char*, Bytes>> files = {
      {"png", test::encode_png(40, 30, {}, test::picture(40, 30, 5))},
      {"jpeg", test::encode_jpeg(40, 30, 3, test::picture(40, 30, 5))}};
  for (const auto& [name, file] : files)
    for (std::size_t size = 0; size < file.size(); ++size)
      ASSERT_NE(color_error(Bytes(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(size))), "")
          << name << " cut to " << size << " of " << file.size() << " bytes";
  const Bytes depth = test::encode_depth_png(40, 30, test::ramp(40, 30, 0));
  for (std::size_t size = 0; size < depth.size(); ++size)
    ASSERT_NE(depth_error(Bytes(depth.begin(), depth.begin() + static_cast<std::ptrdiff_t>(size))), "") << size;
}

TEST(ImageFile, EveryDamagedByteIsSurvived) {
  for (const Bytes& good : {test::encode_png(40, 30, {}, test::picture(40, 30, 5)),
                            test::encode_jpeg(40, 30, 3, test::picture(40, 30, 5))}) {
    for (std::size_t i = 0; i < good.size(); ++i) {
      Bytes file = good;
      file[i] = static_cast<std::uint8_t>(file[i] ^ 0xFF);
      color_error(file);  // an answer, not a crash
      depth_error(file);
    }
  }
}

TEST(ImageFile, DamagedPngPixelsAreAnError) {
  Bytes file = test::encode_depth_png(40, 30, test::ramp(40, 30, 0));
  file[file.size() / 2] ^= 0x10;
  EXPECT_NE(depth_error(file), "");
}

TEST(ImageFile, WrongKindsAreNamed) {
  const Bytes eight_bits = test::encode_png(40, 30, {PNG_COLOR_TYPE_GRAY, 8}, grey_picture());
  const Bytes color = test::encode_png(40, 30, {}, test::picture(40, 30, 0));
  const Bytes jpeg = test::encode_jpeg(40, 30, 1, grey_picture());
  EXPECT_THAT(depth_error(eight_bits), HasSubstr("not a 16-bit grey image"));
  EXPECT_THAT(depth_error(color), HasSubstr("not a 16-bit grey image"));
  EXPECT_THAT(depth_error(jpeg), HasSubstr("not a PNG file"));
  EXPECT_THAT(depth_error({}), HasSubstr("empty"));
  EXPECT_THAT(color_error({}), HasSubstr("empty"));
  EXPECT_THAT(color_error(Bytes(100, 'x')), HasSubstr("neither PNG nor JPEG"));
}

TEST(ImageFile, AnotherSizeIsAnErrorThatNamesBoth) {
  for (const Bytes& file :
       {test::encode_png(20, 10, {}, test::picture(20, 10, 0)), test::encode_jpeg(20, 10, 3, test::picture(20, 10, 0))})
    EXPECT_THAT(color_error(file), testing::AllOf(HasSubstr("20x10"), HasSubstr("40x30")));
  EXPECT_THAT(depth_error(test::encode_depth_png(20, 10, test::ramp(20, 10, 0))), HasSubstr("20x10"));
}

TEST(ImageFile, SizeComesFromTheHeader) {
  for (const Bytes& file : {test::encode_png(20, 10, {}, test::picture(20, 10, 0)),
                            test::encode_jpeg(20, 10, 3, test::picture(20, 10, 0))}) {
    const Result<ImageSize> size = image_size(file);
    ASSERT_TRUE(size.ok());
    EXPECT_EQ(*size, (ImageSize{20, 10}));
  }
  EXPECT_FALSE(image_size(Bytes{1, 2, 3}).ok());
}

TEST(ImageFile, AbsurdSizesAreRefusedBeforeMemoryIsTaken) {
  EXPECT_FALSE(image_size(test::encode_png(9000, 1, {PNG_COLOR_TYPE_GRAY, 8}, Bytes(9000))).ok());
  EXPECT_FALSE(image_size(test::encode_jpeg(9000, 1, 1, Bytes(9000))).ok());
}

}  // namespace
}  // namespace onemap::hal::imaging
