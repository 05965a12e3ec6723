#include "hal/imaging/image_file.hpp"

#include <cassert>

#include "jpeg_decode.hpp"
#include "png_decode.hpp"

namespace onemap::hal::imaging {

namespace {

Error unknown_format(std::span<const std::uint8_t> file) {
  return {"", file.empty() ? "the file is empty" : "neither PNG nor JPEG"};
}

std::string text(ImageSize s) { return std::to_string(s.width) + "x" + std::to_string(s.height); }

Status as_expected(const Result<ImageSize>& decoded, ImageSize expected) {
  if (!decoded) return decoded.error();
  if (*decoded != expected) return Error{"", "the image is " + text(*decoded) + ", expected " + text(expected)};
  return success();
}

}  // namespace

Result<ImageSize> image_size(std::span<const std::uint8_t> file) {
  if (is_png(file)) return decode_png(file, PngWanted::size, {}, nullptr);
  if (is_jpeg(file)) return decode_jpeg(file, JpegWanted::size, {}, nullptr);
  return unknown_format(file);
}

Status decode_color(std::span<const std::uint8_t> file, ImageSize expected, std::span<std::uint8_t> rgb,
                    Chroma chroma) {
  assert(rgb.size() == 3 * static_cast<std::size_t>(expected.width) * static_cast<std::size_t>(expected.height));
  if (is_png(file)) return as_expected(decode_png(file, PngWanted::rgb8, expected, rgb.data()), expected);
  const auto wanted = chroma == Chroma::smooth ? JpegWanted::rgb8 : JpegWanted::rgb8_plain_chroma;
  if (is_jpeg(file)) return as_expected(decode_jpeg(file, wanted, expected, rgb.data()), expected);
  return unknown_format(file);
}

Status decode_depth(std::span<const std::uint8_t> file, ImageSize expected, std::span<std::uint16_t> depth) {
  assert(depth.size() == static_cast<std::size_t>(expected.width) * static_cast<std::size_t>(expected.height));
  if (!is_png(file)) return Error{"", file.empty() ? "the file is empty" : "not a PNG file"};
  auto* bytes = reinterpret_cast<std::uint8_t*>(depth.data());
  return as_expected(decode_png(file, PngWanted::grey16, expected, bytes), expected);
}

}  // namespace onemap::hal::imaging
