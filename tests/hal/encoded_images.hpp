#pragma once
// Images encoded by libpng and libjpeg, for the decoders to read.
#include <png.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <vector>

#include <jpeglib.h>

namespace onemap::test {

using Bytes = std::vector<std::uint8_t>;

struct PngKind {
  int color_type = PNG_COLOR_TYPE_RGB;
  int bit_depth = 8;
  int interlace = PNG_INTERLACE_NONE;
};

inline void append_png_bytes(png_structp png, png_bytep data, std::size_t size) {
  auto* out = static_cast<Bytes*>(png_get_io_ptr(png));
  out->insert(out->end(), data, data + size);
}
inline void no_flush(png_structp) {}

// `rows`: height rows of the file's own samples (16 bit big endian), back to back. A palette image gets a palette in
// which entry i is (i, 2 i, 255 - i) for i below 128.
inline Bytes encode_png(int width, int height, PngKind kind, const Bytes& rows) {
  Bytes out;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  if (setjmp(png_jmpbuf(png))) {
    png_destroy_write_struct(&png, &info);
    throw std::runtime_error("libpng could not write");
  }
  png_set_write_fn(png, &out, append_png_bytes, no_flush);
  png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), kind.bit_depth,
               kind.color_type, kind.interlace, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  if (kind.color_type == PNG_COLOR_TYPE_PALETTE) {
    png_color palette[128];
    for (int i = 0; i < 128; ++i)
      palette[i] = {static_cast<png_byte>(i), static_cast<png_byte>(2 * i), static_cast<png_byte>(255 - i)};
    png_set_PLTE(png, info, palette, 128);
  }
  png_write_info(png, info);
  const int passes = png_set_interlace_handling(png);
  const std::size_t row_bytes = rows.size() / static_cast<std::size_t>(height);
  for (int pass = 0; pass < passes; ++pass)
    for (int y = 0; y < height; ++y) png_write_row(png, rows.data() + static_cast<std::size_t>(y) * row_bytes);
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return out;
}

inline Bytes encode_depth_png(int width, int height, const std::vector<std::uint16_t>& depth) {
  Bytes rows;
  for (const std::uint16_t value : depth) {
    rows.push_back(static_cast<std::uint8_t>(value >> 8));
    rows.push_back(static_cast<std::uint8_t>(value & 0xFF));
  }
  return encode_png(width, height, {PNG_COLOR_TYPE_GRAY, 16, PNG_INTERLACE_NONE}, rows);
}

// How much coarser than brightness colour is, and after how many units a decoder may begin anew; 0: never.
struct JpegLayout {
  int across = 2, down = 2, restart = 0;
};

// components: 3 (RGB) or 1 (grey).
inline Bytes encode_jpeg(int width, int height, int components, const Bytes& pixels, int quality = 95,
                         const JpegLayout& layout = {}) {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* memory = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&jpeg, &memory, &size);
  jpeg.image_width = static_cast<JDIMENSION>(width);
  jpeg.image_height = static_cast<JDIMENSION>(height);
  jpeg.input_components = components;
  jpeg.in_color_space = components == 3 ? JCS_RGB : JCS_GRAYSCALE;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, quality, TRUE);
  jpeg.comp_info[0].h_samp_factor = components == 3 ? layout.across : 1;
  jpeg.comp_info[0].v_samp_factor = components == 3 ? layout.down : 1;
  jpeg.restart_interval = static_cast<unsigned>(layout.restart);
  jpeg_start_compress(&jpeg, TRUE);
  const std::size_t row_bytes = static_cast<std::size_t>(width) * static_cast<std::size_t>(components);
  Bytes row(row_bytes);
  while (jpeg.next_scanline < jpeg.image_height) {
    std::memcpy(row.data(), pixels.data() + jpeg.next_scanline * row_bytes, row_bytes);
    JSAMPROW rows[1] = {row.data()};
    jpeg_write_scanlines(&jpeg, rows, 1);
  }
  jpeg_finish_compress(&jpeg);
  Bytes out(memory, memory + size);
  jpeg_destroy_compress(&jpeg);
  std::free(memory);
  return out;
}

// As MJPEG cameras send it: the segments that hold the standard Huffman tables (0xC4) left out.
inline Bytes without_huffman_tables(const Bytes& jpeg) {
  Bytes out(jpeg.begin(), jpeg.begin() + 2);
  std::size_t at = 2;
  while (jpeg[at + 1] != 0xDA) {  // up to the start of the scan
    const std::size_t size = 2 + (std::size_t{jpeg[at + 2]} << 8 | jpeg[at + 3]);
    if (jpeg[at + 1] != 0xC4)
      out.insert(out.end(), jpeg.begin() + static_cast<std::ptrdiff_t>(at),
                 jpeg.begin() + static_cast<std::ptrdiff_t>(at + size));
    at += size;
  }
  out.insert(out.end(), jpeg.begin() + static_cast<std::ptrdiff_t>(at), jpeg.end());
  return out;
}

// A smooth picture, different in each channel and for each seed.
inline Bytes picture(int width, int height, int seed) {
  Bytes rgb;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (const int value : {x * 3 + seed, y * 4 + 2 * seed, 255 - x - y - seed})
        rgb.push_back(static_cast<std::uint8_t>(value & 0xFF));
  return rgb;
}

inline std::vector<std::uint16_t> ramp(int width, int height, int seed) {
  std::vector<std::uint16_t> depth;
  for (int i = 0; i < width * height; ++i) depth.push_back(static_cast<std::uint16_t>(259 * i + seed));
  return depth;
}

}  // namespace onemap::test
