// The raw colour decoders beside slow references that follow the definitions pixel by pixel.
#include "hal/imaging/raw_colour.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "hal/base/twin.hpp"
#include "mosaic_row.hpp"
#include "support/random.hpp"
#include "yuv_row.hpp"

namespace onemap::hal::imaging {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Decoder = Status (*)(const RawImage&, std::span<std::uint8_t>);
using testing::HasSubstr;

Bytes noise(std::size_t size, std::uint64_t seed) {
  test::Random random(seed);
  Bytes bytes(size);
  for (std::uint8_t& b : bytes) b = static_cast<std::uint8_t>(random.next());
  return bytes;
}

Bytes decoded(Decoder decode, const RawImage& image) {
  Bytes rgb(3 * image.size.pixels());
  const Status status = decode(image, rgb);
  EXPECT_TRUE(status.ok()) << (status ? "" : status.error().text());
  return rgb;
}

std::string error_of(Decoder decode, const RawImage& image) {
  Bytes rgb(3 * image.size.pixels());
  const Status status = decode(image, rgb);
  return status ? "" : status.error().reason;
}

// ITU-R BT.601 in real numbers.
void expect_bt601(double y, double cb, double cr, const std::uint8_t* rgb) {
  const double bright = 255.0 / 219 * (y - 16), scale = 255.0 / 224;
  const double exact[] = {bright + scale * 1.402 * (cr - 128),
                          bright - scale * (0.344136 * (cb - 128) + 0.714136 * (cr - 128)),
                          bright + scale * 1.772 * (cb - 128)};
  for (int i = 0; i < 3; ++i) ASSERT_NEAR(rgb[i], std::clamp(exact[i], 0.0, 255.0), 1.5) << "channel " << i;
}

TEST(RawColour, YuyvAndUyvyAreBt601) {
  constexpr ImageSize kSize{38, 21};
  for (const std::size_t padding : {0u, 6u}) {
    const std::size_t stride = 2 * 38 + padding;
    const Bytes raw = noise(stride * 21, 7 + padding);
    const Bytes yuyv = decoded(yuyv_to_rgb, {raw, kSize, stride}), uyvy = decoded(uyvy_to_rgb, {raw, kSize, stride});
    for (std::size_t y = 0; y < 21; ++y)
      for (std::size_t x = 0; x < 38; ++x) {
        const std::uint8_t* four = &raw[y * stride + x / 2 * 4];
        const std::size_t second = x % 2 * 2;
        expect_bt601(four[second], four[1], four[3], &yuyv[3 * (y * 38 + x)]);
        expect_bt601(four[1 + second], four[0], four[2], &uyvy[3 * (y * 38 + x)]);
      }
  }
}

TEST(RawColour, TheTwinsOfYuvAreEqual) {
  if (!simd_available()) GTEST_SKIP() << "this CPU has no AVX2";
  for (const yuv::Order order : {yuv::Order::yuyv, yuv::Order::uyvy})
    for (std::size_t width = 2; width <= 70; width += 2) {
      const Bytes raw = noise(2 * width, width);
      Bytes plain(3 * width), simd(3 * width);  // of exactly this size: the address sanitizer sees a byte too far
      yuv::row_plain(order, raw.data(), width, plain.data());
      yuv::row_simd(order, raw.data(), width, simd.data());
      EXPECT_EQ(plain, simd) << width;
    }
}

// Every brightness and U, every third V.
TEST(RawColour, TheTwinsOfYuvAreEqualForEveryColour) {
  if (!simd_available()) GTEST_SKIP() << "this CPU has no AVX2";
  constexpr std::size_t kWidth = 512;
  Bytes raw(2 * kWidth), plain(3 * kWidth), simd(3 * kWidth);
  for (int u = 0; u < 256; ++u)
    for (int v = 0; v < 256; v += 3) {
      for (std::size_t x = 0; x < kWidth; ++x) {
        raw[2 * x] = static_cast<std::uint8_t>(x);
        raw[2 * x + 1] = static_cast<std::uint8_t>(x % 2 == 0 ? u : v);
      }
      yuv::row_plain(yuv::Order::yuyv, raw.data(), kWidth, plain.data());
      yuv::row_simd(yuv::Order::yuyv, raw.data(), kWidth, simd.data());
      ASSERT_EQ(plain, simd) << u << ", " << v;
    }
}

TEST(RawColour, BlackWhiteAndPrimaries) {
  const Bytes raw{16, 128, 235, 128, 81, 90, 81, 240};  // black, white, red, red
  EXPECT_THAT(decoded(yuyv_to_rgb, {raw, {4, 1}}), testing::ElementsAre(0, 0, 0, 255, 255, 255, 255, 0, 0, 255, 0, 0));
}

TEST(RawColour, GreyIsTripled) {
  const Bytes raw{1, 2, 3, 99, 4, 5, 6};
  EXPECT_THAT(decoded(grey_to_rgb, {raw, {3, 2}, 4}),
              testing::ElementsAre(1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4, 5, 5, 5, 6, 6, 6));
}

// Which channel a pixel of the mosaic has: G R / B G.
std::size_t channel_at(std::size_t x, std::size_t y) { return x % 2 == y % 2 ? 1 : y % 2 == 0 ? 0 : 2; }

// By definition: the mean of those of the eight neighbours (mirrored at the edges) that have the channel and are
// nearest.
std::uint8_t bayer_reference(const Bytes& raw, int w, int h, int x, int y, std::size_t channel) {
  const auto mirrored = [](int i, int n) { return i < 0 ? -i : i >= n ? 2 * n - 2 - i : i; };
  const auto at = [&](int u, int v) { return raw[static_cast<std::size_t>(mirrored(v, h) * w + mirrored(u, w))]; };
  const auto has = [&](int u, int v) {
    return channel_at(static_cast<std::size_t>(mirrored(u, w)), static_cast<std::size_t>(mirrored(v, h))) == channel;
  };
  for (const int distance2 : {0, 1, 2}) {
    int sum = 0, n = 0;
    for (int dv = -1; dv <= 1; ++dv)
      for (int du = -1; du <= 1; ++du)
        if (du * du + dv * dv == distance2 && has(x + du, y + dv)) {
          sum += at(x + du, y + dv);
          ++n;
        }
    if (n > 0) return static_cast<std::uint8_t>((sum + n / 2) / n);
  }
  ADD_FAILURE() << "no neighbour has the channel";
  return 0;
}

TEST(RawColour, BayerIsTheMeanOfTheNearestNeighbours) {
  for (const auto& [w, h] :
       {std::pair(2, 2), std::pair(3, 2), std::pair(2, 5), std::pair(17, 12), std::pair(32, 9), std::pair(71, 6)}) {
    const Bytes raw = noise(static_cast<std::size_t>(w * h), static_cast<std::uint64_t>(w * 100 + h));
    const Bytes rgb = decoded(bayer_grbg_to_rgb, {raw, {w, h}});
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x)
        for (std::size_t c = 0; c < 3; ++c)
          ASSERT_EQ(rgb[3 * static_cast<std::size_t>(y * w + x) + c], bayer_reference(raw, w, h, x, y, c))
              << w << "x" << h << " at " << x << ", " << y << " channel " << c;
  }
}

TEST(RawColour, TheTwinsOfTheMosaicAreEqual) {
  if (!simd_available()) GTEST_SKIP() << "this CPU has no AVX2";
  for (std::size_t width = 2; width <= 140; ++width)
    for (const bool odd_row : {false, true}) {
      const Bytes raw = noise(3 * width, width);
      const mosaic::Rows rows{raw.data(), raw.data() + width, raw.data() + 2 * width};
      Bytes plain(3 * width), simd(3 * width);  // of exactly this size: the address sanitizer sees a byte too far
      mosaic::row_plain(rows, width, odd_row, plain.data());
      mosaic::row_simd(rows, width, odd_row, simd.data());
      EXPECT_EQ(plain, simd) << width << ", row " << odd_row;
    }
}

TEST(RawColour, ShortImagesAndWrongSizesAreErrorsThatSayThem) {
  const Bytes raw(100);
  EXPECT_THAT(error_of(yuyv_to_rgb, {raw, {8, 7}}), HasSubstr("100 bytes, a 8x7 one has 112"));
  EXPECT_THAT(error_of(uyvy_to_rgb, {raw, {7, 4}}), HasSubstr("odd width, 7"));
  EXPECT_THAT(error_of(yuyv_to_rgb, {raw, {8, 2}, 15}), HasSubstr("rows of 15 bytes where 16 are needed"));
  EXPECT_THAT(error_of(grey_to_rgb, {raw, {101, 1}}), HasSubstr("100 bytes"));
  EXPECT_THAT(error_of(grey_to_rgb, {raw, {0, 4}}), HasSubstr("0x4"));
  EXPECT_THAT(error_of(bayer_grbg_to_rgb, {raw, {100, 1}}), HasSubstr("2x2"));
  EXPECT_THAT(error_of(bayer_grbg_to_rgb, {raw, {60, 2}}), HasSubstr("100 bytes"));
}

TEST(RawColour, EveryLengthHasAnAnswer) {
  constexpr ImageSize kSize{6, 4};
  const std::tuple<Decoder, std::size_t> decoders[] = {
      {yuyv_to_rgb, 48}, {uyvy_to_rgb, 48}, {grey_to_rgb, 24}, {bayer_grbg_to_rgb, 24}};
  for (const auto& [decode, needed] : decoders)
    for (std::size_t size = 0; size <= needed + 3; ++size) {
      const Bytes raw = noise(size, size);  // of exactly this size: the address sanitizer sees a byte too far
      EXPECT_EQ(error_of(decode, {raw, kSize}) == "", size >= needed) << size;
    }
}

}  // namespace
}  // namespace onemap::hal::imaging
