#include <algorithm>
#include <cassert>

#include "hal/imaging/raw_colour.hpp"

namespace onemap::hal::imaging {

namespace {

std::uint8_t clamped(int value) { return static_cast<std::uint8_t>(std::clamp(value >> 8, 0, 255)); }

// BT.601: R = 1.164 (Y - 16) + 1.596 V', G = 1.164 (Y - 16) - 0.392 U' - 0.813 V', B = 1.164 (Y - 16) + 2.017 U', in
// 1/256.
void put_pixel(int y, int red, int green, int blue, std::uint8_t* rgb) {
  const int bright = 298 * (y - 16) + 128;
  rgb[0] = clamped(bright + red);
  rgb[1] = clamped(bright + green);
  rgb[2] = clamped(bright + blue);
}

// y and c: where the first Y and the first colour byte are among the four.
template <int y, int c>
Status to_rgb(const RawImage& image, std::span<std::uint8_t> rgb) {
  assert(rgb.size() == 3 * image.size.pixels());
  if (image.size.width % 2 != 0) return Error{"", "an odd width, " + std::to_string(image.size.width)};
  const std::size_t row_bytes = 2 * static_cast<std::size_t>(std::max(0, image.size.width));
  if (Status status = check_rows(image, row_bytes); !status) return status;
  std::uint8_t* out = rgb.data();
  for (std::size_t v = 0; v < static_cast<std::size_t>(image.size.height); ++v) {
    const std::uint8_t* in = image.bytes.data() + v * image.stride(row_bytes);
    for (const std::uint8_t* end = in + row_bytes; in != end; in += 4, out += 6) {
      const int cb = in[c] - 128, cr = in[c + 2] - 128;
      const int red = 409 * cr, green = -100 * cb - 208 * cr, blue = 516 * cb;
      put_pixel(in[y], red, green, blue, out);
      put_pixel(in[y + 2], red, green, blue, out + 3);
    }
  }
  return success();
}

}  // namespace

Status yuyv_to_rgb(const RawImage& image, std::span<std::uint8_t> rgb) { return to_rgb<0, 1>(image, rgb); }
Status uyvy_to_rgb(const RawImage& image, std::span<std::uint8_t> rgb) { return to_rgb<1, 0>(image, rgb); }

}  // namespace onemap::hal::imaging
