#pragma once
#include "hal/imaging/image_file.hpp"

namespace onemap::hal::imaging {

enum class JpegWanted { size, rgb8, rgb8_plain_chroma };

bool is_jpeg(std::span<const std::uint8_t> file);

// As decode_png.
Result<ImageSize> decode_jpeg(std::span<const std::uint8_t> file, JpegWanted wanted, ImageSize expected,
                              std::uint8_t* pixels);

}  // namespace onemap::hal::imaging
