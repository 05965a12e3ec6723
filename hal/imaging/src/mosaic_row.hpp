#pragma once
#include <cstddef>
#include <cstdint>

// A row of a Bayer mosaic to RGB: the inner loop of bayer_grbg_to_rgb(), and its twin of AVX2, which gives the same
// bytes.
namespace onemap::hal::imaging::mosaic {

// One row with the rows above and below it (mirrored at the edges).
struct Rows {
  const std::uint8_t *above, *here, *below;
};

// An even row alternates green and red, an odd one blue and green. rgb: 3 * width bytes; width at least 2.
void row_plain(const Rows& rows, std::size_t width, bool odd_row, std::uint8_t* rgb);
void row_simd(const Rows& rows, std::size_t width, bool odd_row, std::uint8_t* rgb);  // where simd_available()

// The same for the pixels [begin, end) alone, none of which is at the image's side.
void inner_plain(const Rows& rows, std::size_t begin, std::size_t end, bool odd_row, std::uint8_t* rgb);
// And for the first or the last.
void side_pixel(const Rows& rows, std::size_t width, bool first, bool odd_row, std::uint8_t* rgb);

}  // namespace onemap::hal::imaging::mosaic
