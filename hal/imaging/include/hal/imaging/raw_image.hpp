#pragma once
#include <cstdint>
#include <span>

#include "hal/base/result.hpp"
#include "hal/imaging/image_size.hpp"

namespace onemap::hal::imaging {

// An image as a device hands it over: rows of `stride_bytes`, of which the first are the pixels' and the rest is
// padding; 0: rows without padding. What the bytes mean is the decoder's business.
struct RawImage {
  std::span<const std::uint8_t> bytes;
  ImageSize size;
  std::size_t stride_bytes = 0;

  std::size_t stride(std::size_t row_bytes) const { return stride_bytes == 0 ? row_bytes : stride_bytes; }
};

// Whether the image has the rows that it says, each of row_bytes. The error carries a reason only: an image that is
// too short (the last row needs no padding; longer is fine), a stride that is too small, a size that is no size.
Status check_rows(const RawImage& image, std::size_t row_bytes);

}  // namespace onemap::hal::imaging
