#pragma once
#include <cstdint>
#include <span>

namespace onemap::daemon {

// How bright an image is, 0 to 255: the mean of some of its pixels' green. rgb: 3 bytes a pixel, whole pixels.
double brightness_of(std::span<const std::uint8_t> rgb);

}  // namespace onemap::daemon
