#pragma once
#include <cstdint>
#include <span>

#include "hal/base/result.hpp"
#include "hal/imaging/raw_image.hpp"

namespace onemap::hal::imaging {

// A colour image in a sensor's raw form to 8-bit RGB, row by row; rgb holds 3 * width * height bytes. Total: whatever
// the bytes are, the answer is pixels or an error with a reason (check_rows; the caller knows the place).

// Two pixels in four bytes, Y U Y V or U Y V Y, sharing their colour; the width is even. BT.601 in its video range (Y
// from 16 to 235), as UVC cameras send it.
Status yuyv_to_rgb(const RawImage& image, std::span<std::uint8_t> rgb);
Status uyvy_to_rgb(const RawImage& image, std::span<std::uint8_t> rgb);

// One byte a pixel.
Status grey_to_rgb(const RawImage& image, std::span<std::uint8_t> rgb);

// A Bayer mosaic whose first row is green red, the second blue green (as Kinect v1's): what a pixel lacks is the mean
// of its nearest neighbours that have it, the image mirrored at its edges. Both sides have at least 2 pixels.
Status bayer_grbg_to_rgb(const RawImage& image, std::span<std::uint8_t> rgb);

}  // namespace onemap::hal::imaging
