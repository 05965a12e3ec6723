#include <cstdlib>

#include "jpeg_state.hpp"

#include "hal/imaging/encode_image.hpp"

namespace onemap::hal::imaging {

namespace {

void drop_message(j_common_ptr, int) {}

struct Output {
  unsigned char* bytes;  // malloc's
  unsigned long size;
};

// Everything that may longjmp, called behind setjmp; no object here has a destructor.
void write_jpeg(jpeg_compress_struct& jpeg, ImageSize size, const std::uint8_t* rgb, int quality, Output& output) {
  jpeg_create_compress(&jpeg);
  jpeg_mem_dest(&jpeg, &output.bytes, &output.size);
  jpeg.image_width = static_cast<JDIMENSION>(size.width);
  jpeg.image_height = static_cast<JDIMENSION>(size.height);
  jpeg.input_components = 3;
  jpeg.in_color_space = JCS_RGB;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, quality, TRUE);
  jpeg_start_compress(&jpeg, TRUE);
  const std::size_t row_bytes = std::size_t{3} * jpeg.image_width;
  while (jpeg.next_scanline < jpeg.image_height) {
    JSAMPROW row = const_cast<JSAMPROW>(rgb + jpeg.next_scanline * row_bytes);  // libjpeg only reads it
    jpeg_write_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_compress(&jpeg);
}

bool encode(jpeg_compress_struct& jpeg, JpegState& state, ImageSize size, const std::uint8_t* rgb, int quality,
            Output& output) {
  if (setjmp(state.jump) != 0) return false;  // NOLINT(cert-err52-cpp)
  write_jpeg(jpeg, size, rgb, quality, output);
  return true;
}

}  // namespace

Status encode_jpeg(ImageSize size, std::span<const std::uint8_t> rgb, int quality, std::vector<std::uint8_t>& file) {
  const auto in_range = [](int side) { return side > 0 && side <= kMostSide_px; };
  if (!in_range(size.width) || !in_range(size.height) || rgb.size() != 3 * size.pixels())
    return Error{"", "not as many pixels as its size says"};
  JpegState state{};
  jpeg_compress_struct jpeg{};
  jpeg.err = jpeg_std_error(&state.manager);
  state.manager.error_exit = on_jpeg_error;
  state.manager.emit_message = drop_message;
  Output output{nullptr, 0};
  const bool ok = encode(jpeg, state, size, rgb.data(), quality, output);
  jpeg_destroy_compress(&jpeg);
  if (ok) file.assign(output.bytes, output.bytes + output.size);
  std::free(output.bytes);  // NOLINT(cppcoreguidelines-no-malloc)
  return ok ? success() : Status(Error{"", state.reason});
}

}  // namespace onemap::hal::imaging
