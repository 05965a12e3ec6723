#include "render/image.hpp"

#include <cassert>

namespace onemap::render {

Image::Image(int width_px, int height_px, std::array<std::uint8_t, 3> fill)
    : width(width_px),
      height(height_px),
      rgb(3 * static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px)) {
  for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = fill[i % 3];
}

std::array<std::uint8_t, 3> Image::at(int x, int y) const {
  const std::size_t i = offset(x, y);
  return {rgb[i], rgb[i + 1], rgb[i + 2]};
}

void Image::set(int x, int y, std::array<std::uint8_t, 3> color) {
  const std::size_t i = offset(x, y);
  for (std::size_t c = 0; c < 3; ++c) rgb[i + c] = color[c];
}

std::size_t Image::offset(int x, int y) const {
  assert(x >= 0 && x < width && y >= 0 && y < height);
  return 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
}

}  // namespace onemap::render
