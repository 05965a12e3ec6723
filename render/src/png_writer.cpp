#include "render/png_writer.hpp"

#include <png.h>

#include <csetjmp>

#include "hal/base/file.hpp"

namespace onemap::render {
namespace {

struct Sink {
  std::vector<std::uint8_t> bytes;
  std::string message;
};

void on_data(png_structp png, png_bytep data, png_size_t size) {
  auto& out = static_cast<Sink*>(png_get_io_ptr(png))->bytes;
  out.insert(out.end(), data, data + size);
}

void on_error(png_structp png, png_const_charp message) {
  static_cast<Sink*>(png_get_error_ptr(png))->message = message;
  png_longjmp(png, 1);
}

void on_warning(png_structp, png_const_charp) {}

// libpng reports errors by longjmp: nothing with a destructor may live in this function.
bool encode(png_structp png, png_infop info, const Image& image, Sink& sink) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;  // NOLINT(cert-err52-cpp)
  png_set_write_fn(png, &sink, on_data, nullptr);
  png_set_IHDR(png, info, static_cast<png_uint_32>(image.width), static_cast<png_uint_32>(image.height), 8,
               PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  // A third of the time of the default level for a tenth more bytes.
  png_set_compression_level(png, 3);
  png_set_filter(png, 0, PNG_FILTER_UP);
  png_write_info(png, info);
  const std::size_t stride = 3 * static_cast<std::size_t>(image.width);
  for (std::size_t y = 0; y < static_cast<std::size_t>(image.height); ++y) png_write_row(png, &image.rgb[y * stride]);
  png_write_end(png, info);
  return true;
}

}  // namespace

Result<std::vector<std::uint8_t>> encode_png(const Image& image) {
  const auto pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  if (image.width <= 0 || image.height <= 0 || image.rgb.size() != 3 * pixels)
    return Error{"png", "an image without pixels"};
  Sink sink;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &sink, on_error, on_warning);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  const bool ok = info != nullptr && encode(png, info, image, sink);
  png_destroy_write_struct(&png, &info);
  if (!ok) return Error{"png", sink.message.empty() ? "out of memory" : sink.message};
  return std::move(sink.bytes);
}

Status write_png(const std::string& path, const Image& image, Durable durable) {
  auto bytes = encode_png(image);
  if (!bytes) return Error{path, bytes.error().text()};
  return write_file(path, *bytes, durable);
}

}  // namespace onemap::render
