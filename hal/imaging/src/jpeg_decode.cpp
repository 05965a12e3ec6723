#include "jpeg_decode.hpp"

#include "jpeg_state.hpp"

#include <jerror.h>

namespace onemap::hal::imaging {

namespace {

// libjpeg only warns of damaged data and paints the rest grey; a map must not contain what was made up. Stray bytes
// between segments harm nothing.
void on_message(j_common_ptr jpeg, int level) {
  if (level < 0 && jpeg->err->msg_code != JWRN_EXTRANEOUS_DATA) on_jpeg_error(jpeg);
}

// Everything that may longjmp, called behind setjmp; no object here has a destructor.
void read_jpeg(jpeg_decompress_struct& jpeg, JpegWanted wanted, ImageSize expected, std::uint8_t* pixels,
               ImageSize& size) {
  jpeg_read_header(&jpeg, TRUE);
  if (jpeg.image_width > kMostSide_px || jpeg.image_height > kMostSide_px)
    ERREXIT1((&jpeg), JERR_IMAGE_TOO_BIG, kMostSide_px);
  size = {static_cast<int>(jpeg.image_width), static_cast<int>(jpeg.image_height)};
  if (wanted == JpegWanted::size || size != expected) return;
  jpeg.out_color_space = JCS_RGB;
  jpeg.do_fancy_upsampling = wanted == JpegWanted::rgb8 ? TRUE : FALSE;
  jpeg_start_decompress(&jpeg);
  const std::size_t row_bytes = std::size_t{3} * jpeg.output_width;
  while (jpeg.output_scanline < jpeg.output_height) {
    JSAMPROW rows[4];
    JDIMENSION count = 0;
    for (; count < 4 && jpeg.output_scanline + count < jpeg.output_height; ++count)
      rows[count] = pixels + (jpeg.output_scanline + count) * row_bytes;
    jpeg_read_scanlines(&jpeg, rows, count);
  }
  jpeg_finish_decompress(&jpeg);
}

}  // namespace

bool is_jpeg(std::span<const std::uint8_t> file) {
  return file.size() >= 3 && file[0] == 0xFF && file[1] == 0xD8 && file[2] == 0xFF;
}

Result<ImageSize> decode_jpeg(std::span<const std::uint8_t> file, JpegWanted wanted, ImageSize expected,
                              std::uint8_t* pixels) {
  JpegState state{};
  jpeg_decompress_struct jpeg{};
  ImageSize size;
  jpeg.err = jpeg_std_error(&state.manager);
  state.manager.error_exit = on_jpeg_error;
  state.manager.emit_message = on_message;
  const bool failed = setjmp(state.jump) != 0;
  if (!failed) {
    jpeg_create_decompress(&jpeg);
    jpeg_mem_src(&jpeg, file.data(), static_cast<unsigned long>(file.size()));
    read_jpeg(jpeg, wanted, expected, pixels, size);
  }
  jpeg_destroy_decompress(&jpeg);
  if (failed) return Error{"", std::string("JPEG: ") + state.reason};
  return size;
}

}  // namespace onemap::hal::imaging
