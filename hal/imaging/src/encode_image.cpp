#include "hal/imaging/encode_image.hpp"

#include <png.h>

#include <bit>
#include <csetjmp>
#include <cstdio>

namespace onemap::hal::imaging {

namespace {

constexpr int kCompression = 1;
// zlib's Z_HUFFMAN_ONLY: a photograph's noise does not repeat, so looking for repetitions costs a third of the time and
// makes the file larger. Depth has holes and steps that do repeat.
constexpr int kHuffmanOnly = 2;

struct Pixels {
  ImageSize size;
  const std::uint8_t* first;
  std::size_t row_bytes;
  int depth_bits, colour_type;
};

struct Sink {
  std::vector<std::uint8_t>* file;
  bool full;
  char reason[128];
};

[[noreturn]] void on_error(png_structp png, png_const_charp message) {
  auto* sink = static_cast<Sink*>(png_get_error_ptr(png));
  std::snprintf(sink->reason, sizeof sink->reason, "%s", message);
  png_longjmp(png, 1);
}

void on_warning(png_structp, png_const_charp) {}

// An exception must not pass through libpng, which is C.
void on_data(png_structp png, png_bytep data, png_size_t size) {
  auto* sink = static_cast<Sink*>(png_get_io_ptr(png));
  try {
    sink->file->insert(sink->file->end(), data, data + size);
  } catch (...) {
    sink->full = true;
  }
  if (sink->full) png_error(png, "out of memory");
}

// libpng reports errors by longjmp: nothing with a destructor may live in this function.
bool write_png(png_structp png, png_infop info, const Pixels& pixels, Sink& sink) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;  // NOLINT(cert-err52-cpp)
  png_set_write_fn(png, &sink, on_data, nullptr);
  png_set_IHDR(png, info, static_cast<png_uint_32>(pixels.size.width), static_cast<png_uint_32>(pixels.size.height),
               pixels.depth_bits, pixels.colour_type, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_set_compression_level(png, kCompression);
  if (pixels.depth_bits == 8) png_set_compression_strategy(png, kHuffmanOnly);
  png_set_filter(png, 0, pixels.depth_bits == 8 ? PNG_FILTER_UP : PNG_FILTER_SUB);
  png_write_info(png, info);
  if constexpr (std::endian::native == std::endian::little)
    if (pixels.depth_bits == 16) png_set_swap(png);
  for (int y = 0; y < pixels.size.height; ++y)
    png_write_row(png, pixels.first + static_cast<std::size_t>(y) * pixels.row_bytes);
  png_write_end(png, info);
  return true;
}

Status encode(const Pixels& pixels, std::vector<std::uint8_t>& file) {
  file.clear();
  Sink sink{&file, false, {}};
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &sink, on_error, on_warning);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  const bool ok = info != nullptr && write_png(png, info, pixels, sink);
  png_destroy_write_struct(&png, &info);
  if (!ok) return Error{"", sink.reason[0] == 0 ? "out of memory" : sink.reason};
  return success();
}

bool fits(ImageSize size, std::size_t values, std::size_t channels) {
  const auto in_range = [](int side) { return side > 0 && side <= kMostSide_px; };
  return in_range(size.width) && in_range(size.height) &&
         values == channels * static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
}

}  // namespace

Status encode_colour(ImageSize size, std::span<const std::uint8_t> rgb, std::vector<std::uint8_t>& file) {
  if (!fits(size, rgb.size(), 3)) return Error{"", "not as many pixels as its size says"};
  return encode({size, rgb.data(), 3 * static_cast<std::size_t>(size.width), 8, PNG_COLOR_TYPE_RGB}, file);
}

Status encode_depth(ImageSize size, std::span<const std::uint16_t> depth, std::vector<std::uint8_t>& file) {
  if (!fits(size, depth.size(), 1)) return Error{"", "not as many pixels as its size says"};
  return encode({size, reinterpret_cast<const std::uint8_t*>(depth.data()), 2 * static_cast<std::size_t>(size.width),
                 16, PNG_COLOR_TYPE_GRAY},
                file);
}

}  // namespace onemap::hal::imaging
