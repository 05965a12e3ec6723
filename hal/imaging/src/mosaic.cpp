#include <algorithm>
#include <cassert>

#include "hal/base/twin.hpp"
#include "hal/imaging/raw_colour.hpp"
#include "mosaic_row.hpp"

namespace onemap::hal::imaging {

namespace mosaic {

namespace {

std::uint8_t mean(int a, int b) { return static_cast<std::uint8_t>((a + b + 1) / 2); }
std::uint8_t mean(int a, int b, int c, int d) { return static_cast<std::uint8_t>((a + b + c + d + 2) / 4); }

// A pixel of a row that alternates green and `own`: own is red (0) in even rows, blue (2) in odd ones.
void put_pixel(const Rows& rows, std::size_t left, std::size_t x, std::size_t right, bool green, std::size_t own,
               std::uint8_t* rgb) {
  const auto [above, here, below] = rows;
  const std::size_t other = 2 - own;
  if (green) {
    rgb[own] = mean(here[left], here[right]);
    rgb[1] = here[x];
    rgb[other] = mean(above[x], below[x]);
  } else {
    rgb[own] = here[x];
    rgb[1] = mean(here[left], here[right], above[x], below[x]);
    rgb[other] = mean(above[left], above[right], below[left], below[right]);
  }
}

bool is_green(std::size_t x, bool odd_row) { return (x % 2 == 0) != odd_row; }

}  // namespace

void inner_plain(const Rows& rows, std::size_t begin, std::size_t end, bool odd_row, std::uint8_t* rgb) {
  for (std::size_t x = begin; x < end; ++x)
    put_pixel(rows, x - 1, x, x + 1, is_green(x, odd_row), odd_row ? 2 : 0, rgb + 3 * x);
}

void side_pixel(const Rows& rows, std::size_t width, bool first, bool odd_row, std::uint8_t* rgb) {
  const std::size_t x = first ? 0 : width - 1, inside = first ? 1 : width - 2;
  put_pixel(rows, inside, x, inside, is_green(x, odd_row), odd_row ? 2 : 0, rgb + 3 * x);
}

void row_plain(const Rows& rows, std::size_t width, bool odd_row, std::uint8_t* rgb) {
  side_pixel(rows, width, true, odd_row, rgb);
  inner_plain(rows, 1, width - 1, odd_row, rgb);
  side_pixel(rows, width, false, odd_row, rgb);
}

}  // namespace mosaic

Status grey_to_rgb(const RawImage& image, std::span<std::uint8_t> rgb) {
  assert(rgb.size() == 3 * image.size.pixels());
  const auto width = static_cast<std::size_t>(std::max(0, image.size.width));
  if (Status status = check_rows(image, width); !status) return status;
  std::uint8_t* out = rgb.data();
  for (std::size_t v = 0; v < static_cast<std::size_t>(image.size.height); ++v)
    for (const std::uint8_t value : image.bytes.subspan(v * image.stride(width), width))
      out = std::fill_n(out, 3, value);
  return success();
}

Status bayer_grbg_to_rgb(const RawImage& image, std::span<std::uint8_t> rgb) {
  assert(rgb.size() == 3 * image.size.pixels());
  const auto width = static_cast<std::size_t>(std::max(0, image.size.width));
  if (Status status = check_rows(image, width); !status) return status;
  const auto height = static_cast<std::size_t>(image.size.height);
  if (width < 2 || height < 2) return Error{"", "a mosaic has at least 2x2 pixels"};
  const auto row = [&](std::size_t v) { return image.bytes.data() + v * image.stride(width); };
  const auto fill_row = simd_available() ? mosaic::row_simd : mosaic::row_plain;
  for (std::size_t v = 0; v < height; ++v) {
    const mosaic::Rows rows{row(v == 0 ? 1 : v - 1), row(v), row(v + 1 == height ? v - 1 : v + 1)};
    fill_row(rows, width, v % 2 == 1, rgb.data() + 3 * v * width);
  }
  return success();
}

}  // namespace onemap::hal::imaging
