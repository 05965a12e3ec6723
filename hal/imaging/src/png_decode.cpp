#include "png_decode.hpp"

#include <png.h>

#include <algorithm>
#include <bit>
#include <csetjmp>
#include <cstdio>
#include <cstring>

namespace onemap::hal::imaging {

namespace {

// What libpng's callbacks see. Plain data: a longjmp passes over it.
struct PngState {
  const std::uint8_t* data;
  std::size_t left;
  char reason[128];
};

void read_bytes(png_structp png, png_bytep out, std::size_t count) {
  auto* state = static_cast<PngState*>(png_get_io_ptr(png));
  if (state->left < count) png_error(png, "the file ends early");
  std::memcpy(out, state->data, count);
  state->data += count;
  state->left -= count;
}

[[noreturn]] void on_read_error(png_structp png, png_const_charp message) {
  auto* state = static_cast<PngState*>(png_get_error_ptr(png));
  std::snprintf(state->reason, sizeof state->reason, "%s", message);
  png_longjmp(png, 1);
}

void on_read_warning(png_structp, png_const_charp) {}  // about ancillary chunks, which are not used

void want_rgb8(png_structp png, png_infop info) {
  png_set_expand(png);  // palette to RGB, grey to 8 bits
  png_set_strip_16(png);
  png_set_strip_alpha(png);
  const int type = png_get_color_type(png, info);
  if (type == PNG_COLOR_TYPE_GRAY || type == PNG_COLOR_TYPE_GRAY_ALPHA) png_set_gray_to_rgb(png);
}

void want_grey16(png_structp png, png_infop info) {
  if (png_get_color_type(png, info) != PNG_COLOR_TYPE_GRAY || png_get_bit_depth(png, info) != 16)
    png_error(png, "not a 16-bit grey image");
  if constexpr (std::endian::native == std::endian::little) png_set_swap(png);
}

// Everything that may longjmp, called behind setjmp; no object here has a destructor.
void read_png(png_structp png, png_infop info, PngWanted wanted, ImageSize expected, std::uint8_t* pixels,
              ImageSize& size) {
  png_set_user_limits(png, kMostSide_px, kMostSide_px);
  png_read_info(png, info);
  size = {static_cast<int>(png_get_image_width(png, info)), static_cast<int>(png_get_image_height(png, info))};
  if (wanted == PngWanted::size || size != expected) return;
  if (wanted == PngWanted::rgb8) want_rgb8(png, info);
  if (wanted == PngWanted::grey16) want_grey16(png, info);
  const int passes = png_set_interlace_handling(png);
  png_read_update_info(png, info);
  const std::size_t row_bytes = static_cast<std::size_t>(size.width) * (wanted == PngWanted::rgb8 ? 3 : 2);
  if (png_get_rowbytes(png, info) != row_bytes) png_error(png, "an unexpected kind of pixels");
  for (int pass = 0; pass < passes; ++pass)
    for (int y = 0; y < size.height; ++y) png_read_row(png, pixels + static_cast<std::size_t>(y) * row_bytes, nullptr);
  png_read_end(png, nullptr);
}

}  // namespace

bool is_png(std::span<const std::uint8_t> file) { return file.size() >= 8 && png_sig_cmp(file.data(), 0, 8) == 0; }

Result<ImageSize> decode_png(std::span<const std::uint8_t> file, PngWanted wanted, ImageSize expected,
                             std::uint8_t* pixels) {
  PngState state{file.data(), file.size(), {}};
  ImageSize size;
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &state, on_read_error, on_read_warning);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  if (!info) {
    png_destroy_read_struct(&png, nullptr, nullptr);
    return Error{"", "libpng could not start"};
  }
  png_set_read_fn(png, &state, read_bytes);
  const bool failed = setjmp(png_jmpbuf(png)) != 0;
  if (!failed) read_png(png, info, wanted, expected, pixels, size);
  png_destroy_read_struct(&png, &info, nullptr);
  if (failed) return Error{"", std::string("PNG: ") + state.reason};
  return size;
}

}  // namespace onemap::hal::imaging
