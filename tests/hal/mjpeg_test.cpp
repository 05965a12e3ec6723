// MJPEG images, as cameras send them, beside a slow reference that follows the standard term by term.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "hal/encoded_images.hpp"
#include "hal/imaging/image_file.hpp"
#include "hal/slow_jpeg.hpp"
#include "support/random.hpp"

namespace onemap::hal::imaging {
namespace {

// Soft shapes with hard edges and noise on them.
std::vector<std::uint8_t> busy_picture(int width, int height, std::uint64_t seed) {
  test::Random random(seed);
  auto pixels = test::picture(width, height, static_cast<int>(seed));
  for (std::uint8_t& value : pixels)
    value = static_cast<std::uint8_t>(std::clamp<int>(value + static_cast<int>(random.next() % 31) - 15, 0, 255));
  return pixels;
}

// The fast decoder rounds its cosines and its colours to whole numbers on the way.
void expect_as_the_standard_says(const std::vector<std::uint8_t>& jpeg, const test::SlowJpeg& slow,
                                 const std::string& what) {
  const ImageSize size{slow.width(), slow.height()};
  std::vector<std::uint8_t> fast(3 * size.pixels());
  const Status status = decode_color(jpeg, size, fast, Chroma::plain);
  ASSERT_TRUE(status.ok()) << what << ": " << status.error().text();
  const std::vector<std::uint8_t> exact = slow.rgb();
  int worst = 0;
  double sum = 0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    worst = std::max(worst, std::abs(fast[i] - exact[i]));
    sum += fast[i] - exact[i];
  }
  EXPECT_LE(worst, 4) << what;
  EXPECT_LT(std::abs(sum / static_cast<double>(exact.size())), 0.3) << what << ": in the mean";
}

TEST(Mjpeg, IsWhatTheStandardSays) {
  const test::JpegLayout layouts[] = {{2, 1, 0}, {2, 2, 0}, {1, 1, 0}, {1, 2, 0}, {2, 1, 3}, {2, 2, 1}};
  for (const auto& [across, down, restart] : layouts)
    for (const auto& [width, height] : {std::pair(48, 32), std::pair(37, 21), std::pair(8, 8)})
      for (const int quality : {30, 85, 100}) {
        const auto pixels = busy_picture(width, height, static_cast<std::uint64_t>(width + quality));
        const auto jpeg = test::encode_jpeg(width, height, 3, pixels, quality, {across, down, restart});
        expect_as_the_standard_says(jpeg, test::SlowJpeg(jpeg),
                                    testing::PrintToString(std::array{across, down, restart, width, height, quality}));
      }
}

TEST(Mjpeg, GreyIsWhatTheStandardSays) {
  const auto pixels = busy_picture(40, 30, 4);
  std::vector<std::uint8_t> grey(40 * 30);
  for (std::size_t i = 0; i < grey.size(); ++i) grey[i] = pixels[3 * i];
  const auto jpeg = test::encode_jpeg(40, 30, 1, grey, 90);
  expect_as_the_standard_says(jpeg, test::SlowJpeg(jpeg), "grey");
}

// The reference takes the tables from the file that has them, the decoder from the standard.
TEST(Mjpeg, WithoutItsTablesItIsTheSame) {
  const auto jpeg = test::encode_jpeg(48, 32, 3, busy_picture(48, 32, 9), 85, {2, 1, 3});
  const auto motion = test::without_huffman_tables(jpeg);
  ASSERT_LT(motion.size(), jpeg.size() - 300);
  expect_as_the_standard_says(motion, test::SlowJpeg(motion, test::SlowJpeg(jpeg).tables()), "without tables");
}

// What the reference decodes is the picture, so that two decoders that are wrong alike are seen.
TEST(Mjpeg, TheReferenceSeesThePicture) {
  const auto pixels = test::picture(48, 32, 3);
  const test::SlowJpeg slow(test::encode_jpeg(48, 32, 3, pixels, 100, {1, 1, 0}));
  const auto rgb = slow.rgb();
  ASSERT_EQ(rgb.size(), pixels.size());
  double sum = 0;
  for (std::size_t i = 0; i < rgb.size(); ++i) sum += std::abs(rgb[i] - pixels[i]);
  EXPECT_LT(sum / static_cast<double>(rgb.size()), 2);
}

}  // namespace
}  // namespace onemap::hal::imaging
