#include "texture.hpp"

#include <cassert>

namespace onemap::hal::simulated {

Texture::Texture(const std::vector<std::uint8_t>& base, int width, int height, double texel_m) : texel_m_(texel_m) {
  assert(width >= 2 && height >= 2 &&
         base.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  texels_.reserve(base.size() * 4 / 3 + 4 * static_cast<std::size_t>(width + height));
  texels_.assign(base.begin(), base.end());
  levels_[0] = {0, width, height};
  int count = 1;
  while (count < kMaxLevels && std::min(levels_[static_cast<std::size_t>(count - 1)].width,
                                        levels_[static_cast<std::size_t>(count - 1)].height) >= 4) {
    const Level& from = levels_[static_cast<std::size_t>(count - 1)];
    levels_[static_cast<std::size_t>(count)] = {texels_.size(), (from.width + 1) / 2, (from.height + 1) / 2};
    add_level(from);
    ++count;
  }
  max_level8_ = (count - 1) * 256;
}

void Texture::add_level(const Level& from) {
  const int w = from.width, h = from.height;
  for (int y = 0; y < h; y += 2) {
    const std::size_t row = from.offset + static_cast<std::size_t>(y) * static_cast<std::size_t>(w);
    const std::size_t below = y + 1 < h ? row + static_cast<std::size_t>(w) : row;
    for (int x = 0; x < w; x += 2) {
      const auto a = static_cast<std::size_t>(x), b = static_cast<std::size_t>(std::min(x + 1, w - 1));
      const int sum = texels_[row + a] + texels_[row + b] + texels_[below + a] + texels_[below + b];
      texels_.push_back(static_cast<std::uint8_t>((sum + 2) / 4));
    }
  }
}

}  // namespace onemap::hal::simulated
