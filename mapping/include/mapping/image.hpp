#pragma once
#include <cstdint>
#include <span>

#include "hal/frame.hpp"

namespace onemap::mapping {

// A view of an 8-bit grey image, row by row, stride in bytes.
struct GrayView {
  const std::uint8_t* data = nullptr;
  int width = 0, height = 0, stride = 0;
  const std::uint8_t* row(int y) const { return data + static_cast<std::ptrdiff_t>(y) * stride; }
};

// Grey = (77 R + 150 G + 29 B + 128) / 256 (ITU-R BT.601 luma), integer arithmetic. out: width x height.
void to_gray(std::span<const std::uint8_t> rgb, std::span<std::uint8_t> out);

}  // namespace onemap::mapping
