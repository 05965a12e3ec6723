#include "hal/backends/openni2/decode.hpp"

#include <algorithm>
#include <cstring>

#include "hal/imaging/raw_colour.hpp"
#include "hal/imaging/raw_depth.hpp"

namespace onemap::hal::openni2 {

namespace {

Status rgb_to_rgb(const imaging::RawImage& image, std::span<std::uint8_t> rgb) {
  const std::size_t row = 3 * static_cast<std::size_t>(std::max(image.size.width, 0));
  if (const Status status = imaging::check_rows(image, row); !status) return status.error();
  for (std::size_t y = 0; y < static_cast<std::size_t>(image.size.height); ++y)
    std::memcpy(rgb.data() + y * row, image.bytes.data() + y * image.stride(row), row);
  return success();
}

Status unmirrored(PixelFormat format, const imaging::RawImage& image, std::span<std::uint8_t> rgb) {
  switch (format) {
    case PixelFormat::rgb888:
      return rgb_to_rgb(image, rgb);
    case PixelFormat::yuv422:
      return imaging::uyvy_to_rgb(image, rgb);
    case PixelFormat::yuyv:
      return imaging::yuyv_to_rgb(image, rgb);
    case PixelFormat::grey8:
      return imaging::grey_to_rgb(image, rgb);
    default:
      return Error{"", "its pixel format is no colour image"};
  }
}

}  // namespace

bool is_depth(PixelFormat format) { return format == PixelFormat::depth_1_mm || format == PixelFormat::depth_100_um; }
bool is_colour(PixelFormat format) { return !is_depth(format) && format != PixelFormat::other; }
double units_per_metre(PixelFormat depth) { return depth == PixelFormat::depth_100_um ? 10000 : 1000; }

Status decode_colour(PixelFormat format, const imaging::RawImage& image, bool mirrored, std::span<std::uint8_t> rgb) {
  if (Status status = unmirrored(format, image, rgb); !status || !mirrored) return status;
  const auto width = static_cast<std::size_t>(image.size.width);
  for (std::size_t row = 0; row < image.size.pixels(); row += width) {
    std::uint8_t* pixels = rgb.data() + 3 * row;
    for (std::size_t left = 0, right = width - 1; left < right; ++left, --right)
      std::swap_ranges(pixels + 3 * left, pixels + 3 * left + 3, pixels + 3 * right);
  }
  return success();
}

Status decode_depth(const imaging::RawImage& image, bool mirrored, std::span<std::uint16_t> depth) {
  if (Status status = imaging::z16_to_depth(image, depth); !status || !mirrored) return status;
  const auto width = static_cast<std::ptrdiff_t>(image.size.width);
  for (auto row = depth.begin(); row != depth.begin() + width * image.size.height; row += width)
    std::reverse(row, row + width);
  return success();
}

}  // namespace onemap::hal::openni2
