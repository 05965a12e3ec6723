#include <algorithm>
#include <cassert>

#include "hal/base/twin.hpp"
#include "hal/imaging/raw_colour.hpp"
#include "yuv_row.hpp"

namespace onemap::hal::imaging {

namespace yuv {

namespace {

std::uint8_t clamped(int value) { return static_cast<std::uint8_t>(std::clamp(value >> 8, 0, 255)); }

void put_pixel(int y, int red, int green, int blue, std::uint8_t* rgb) {
  const int bright = kY * (y - 16) + kHalf;
  rgb[0] = clamped(bright + red);
  rgb[1] = clamped(bright + green);
  rgb[2] = clamped(bright + blue);
}

template <Order order>
void convert(const std::uint8_t* in, std::size_t width, std::uint8_t* rgb) {
  constexpr std::size_t y = order == Order::yuyv ? 0 : 1, c = 1 - y;  // the first Y and the first colour byte
  for (const std::uint8_t* end = in + 2 * width; in != end; in += 4, rgb += 6) {
    const int u = in[c] - 128, v = in[c + 2] - 128;
    const int red = kRedOfV * v, green = kGreenOfU * u + kGreenOfV * v, blue = kBlueOfU * u;
    put_pixel(in[y], red, green, blue, rgb);
    put_pixel(in[y + 2], red, green, blue, rgb + 3);
  }
}

}  // namespace

void row_plain(Order order, const std::uint8_t* in, std::size_t width, std::uint8_t* rgb) {
  (order == Order::yuyv ? convert<Order::yuyv> : convert<Order::uyvy>)(in, width, rgb);
}

}  // namespace yuv

namespace {

Status to_rgb(yuv::Order order, const RawImage& image, std::span<std::uint8_t> rgb) {
  assert(rgb.size() == 3 * image.size.pixels());
  if (image.size.width % 2 != 0) return Error{"", "an odd width, " + std::to_string(image.size.width)};
  const auto width = static_cast<std::size_t>(std::max(0, image.size.width));
  if (Status status = check_rows(image, 2 * width); !status) return status;
  const auto row = simd_available() ? yuv::row_simd : yuv::row_plain;
  for (std::size_t v = 0; v < static_cast<std::size_t>(image.size.height); ++v)
    row(order, image.bytes.data() + v * image.stride(2 * width), width, rgb.data() + 3 * v * width);
  return success();
}

}  // namespace

Status yuyv_to_rgb(const RawImage& image, std::span<std::uint8_t> rgb) { return to_rgb(yuv::Order::yuyv, image, rgb); }
Status uyvy_to_rgb(const RawImage& image, std::span<std::uint8_t> rgb) { return to_rgb(yuv::Order::uyvy, image, rgb); }

}  // namespace onemap::hal::imaging
