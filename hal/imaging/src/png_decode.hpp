#pragma once
#include "hal/imaging/image_file.hpp"

namespace onemap::hal::imaging {

enum class PngWanted { size, rgb8, grey16 };

bool is_png(std::span<const std::uint8_t> file);

// Reads the header and, unless only the size is wanted, all rows into `pixels` (3 bytes or one native 16-bit value a
// pixel), whose room for `expected` the caller guarantees. Returns the size that the header gives.
Result<ImageSize> decode_png(std::span<const std::uint8_t> file, PngWanted wanted, ImageSize expected,
                             std::uint8_t* pixels);

}  // namespace onemap::hal::imaging
