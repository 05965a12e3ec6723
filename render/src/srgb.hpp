#pragma once
#include <cstdint>

namespace onemap::render {

// Photographs are sRGB, glTF's vertex colours are linear. 16 bits keep the dark tones apart: every 8-bit value comes
// back.
std::uint16_t linear_from_srgb(std::uint8_t value);
std::uint8_t srgb_from_linear(std::uint16_t value);

}  // namespace onemap::render
