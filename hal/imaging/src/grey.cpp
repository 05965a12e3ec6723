#include <algorithm>
#include <cassert>

#include "hal/imaging/raw_colour.hpp"

namespace onemap::hal::imaging {

Status grey_to_rgb(const RawImage& image, std::span<std::uint8_t> rgb) {
  assert(rgb.size() == 3 * image.size.pixels());
  const auto width = static_cast<std::size_t>(std::max(0, image.size.width));
  if (Status status = check_rows(image, width); !status) return status;
  std::uint8_t* out = rgb.data();
  for (std::size_t v = 0; v < static_cast<std::size_t>(image.size.height); ++v)
    for (const std::uint8_t value : image.bytes.subspan(v * image.stride(width), width))
      out = std::fill_n(out, 3, value);
  return success();
}

}  // namespace onemap::hal::imaging
