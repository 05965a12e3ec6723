#pragma once
#include <cstdint>
#include <span>

#include "hal/base/result.hpp"
#include "hal/imaging/image_size.hpp"

namespace onemap::hal::imaging {

// Pure functions from a file's bytes to pixels. Their errors carry a reason only; the caller knows the place.

// From the header alone, PNG or JPEG. The largest side that is accepted is 8192 pixels.
Result<ImageSize> image_size(std::span<const std::uint8_t> file);

// PNG (any kind; alpha is dropped, 16 bit samples keep their high byte) or JPEG (RGB or grey) to 8-bit RGB, row by row;
// rgb holds 3 * width * height bytes. A JPEG without Huffman tables has the standard ones (MJPEG cameras leave them
// out). Any damage, a missing end included, is an error; rgb is then unspecified.
// Chroma::plain repeats what a JPEG says of several pixels' colour instead of running it smoothly between them: a tenth
// faster, for pictures that come thirty times a second.
enum class Chroma : std::uint8_t { smooth, plain };
Status decode_color(std::span<const std::uint8_t> file, ImageSize expected, std::span<std::uint8_t> rgb,
                    Chroma chroma = Chroma::smooth);

// 16-bit grey PNG to native values; depth holds width * height values. Damage is an error, as above.
Status decode_depth(std::span<const std::uint8_t> file, ImageSize expected, std::span<std::uint16_t> depth);

}  // namespace onemap::hal::imaging
