#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "hal/base/result.hpp"
#include "hal/imaging/image_size.hpp"

namespace onemap::hal::imaging {

// Pure functions from pixels to a file's bytes, the other way round from image_file.hpp. The same pixels give the same
// bytes; PNG is lossless and has the weakest compression that is still one, for the speed of a camera. `file` is
// emptied, and its memory used again. Errors carry a reason only.

// rgb: height x width x 3 bytes, row by row.
Status encode_colour(ImageSize size, std::span<const std::uint8_t> rgb, std::vector<std::uint8_t>& file);

// 16-bit grey; depth: height x width values.
Status encode_depth(ImageSize size, std::span<const std::uint16_t> depth, std::vector<std::uint8_t>& file);

// JPEG, for people's eyes. quality: 1..100.
Status encode_jpeg(ImageSize size, std::span<const std::uint8_t> rgb, int quality, std::vector<std::uint8_t>& file);

}  // namespace onemap::hal::imaging
