#pragma once
#include <cstdint>
#include <span>

#include "hal/base/result.hpp"
#include "hal/imaging/raw_image.hpp"

namespace onemap::hal::openni2 {

// What OpenNI2's pixel formats hold; the formats that are no picture for us (compressed, raw disparity) are other.
enum class PixelFormat : std::uint8_t { depth_1_mm, depth_100_um, rgb888, yuv422, yuyv, grey8, other };
bool is_depth(PixelFormat format);
bool is_colour(PixelFormat format);
double units_per_metre(PixelFormat depth);

// Images as OpenNI2 hands them over, turned over left to right when they are mirrored. Total: whatever the bytes are,
// the answer is pixels or an error with a reason.
Status decode_colour(PixelFormat format, const imaging::RawImage& image, bool mirrored, std::span<std::uint8_t> rgb);
Status decode_depth(const imaging::RawImage& image, bool mirrored, std::span<std::uint16_t> depth);

}  // namespace onemap::hal::openni2
