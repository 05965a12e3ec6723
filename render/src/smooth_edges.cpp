#include "smooth_edges.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace onemap::render {
namespace {

constexpr int kLeastContrast = 20;  // of brightness 0..255
constexpr float kLongest_px = 6;    // along an edge

std::vector<std::uint8_t> brightness_of(const Image& image) {
  std::vector<std::uint8_t> out(image.rgb.size() / 3);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const std::uint8_t* c = &image.rgb[3 * i];
    out[i] = static_cast<std::uint8_t>((77 * c[0] + 150 * c[1] + 29 * c[2]) >> 8);
  }
  return out;
}

using Mean = std::array<float, 3>;

// Bilinear, inside the picture.
Mean sample(const Image& image, float x, float y) {
  x = std::clamp(x, 0.0f, static_cast<float>(image.width) - 1.001f);
  y = std::clamp(y, 0.0f, static_cast<float>(image.height) - 1.001f);
  const auto x0 = static_cast<std::size_t>(x), y0 = static_cast<std::size_t>(y);
  const float fx = x - static_cast<float>(x0), fy = y - static_cast<float>(y0);
  const std::uint8_t* top = &image.rgb[3 * (y0 * static_cast<std::size_t>(image.width) + x0)];
  const std::uint8_t* bottom = top + 3 * static_cast<std::size_t>(image.width);
  Mean out{};
  for (std::size_t c = 0; c < 3; ++c) {
    const float upper = static_cast<float>(top[c]) * (1 - fx) + static_cast<float>(top[c + 3]) * fx;
    const float lower = static_cast<float>(bottom[c]) * (1 - fx) + static_cast<float>(bottom[c + 3]) * fx;
    out[c] = upper * (1 - fy) + lower * fy;
  }
  return out;
}

Mean mean(const Mean& a, const Mean& b) { return {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2}; }
float brightness(const Mean& c) { return (77 * c[0] + 150 * c[1] + 29 * c[2]) / 256; }

}  // namespace

void smooth_edges(Image& image) {
  if (image.width < 3 || image.height < 3) return;
  const std::vector<std::uint8_t> light = brightness_of(image);
  const Image before = image;
  const auto width = static_cast<std::size_t>(image.width);
  for (std::size_t y = 1; y + 1 < static_cast<std::size_t>(image.height); ++y) {
    for (std::size_t x = 1; x + 1 < width; ++x) {
      const std::uint8_t* at = &light[y * width + x];
      const int nw = at[-1 - static_cast<std::ptrdiff_t>(width)], ne = at[1 - static_cast<std::ptrdiff_t>(width)];
      const int sw = at[width - 1], se = at[width + 1], here = *at;
      const int low = std::min({nw, ne, sw, se, here}), high = std::max({nw, ne, sw, se, here});
      if (high - low < std::max(kLeastContrast, high / 8)) continue;
      float dx = static_cast<float>(sw + se - nw - ne), dy = static_cast<float>(nw + sw - ne - se);  // along the edge
      const float reduce = std::max(static_cast<float>(nw + ne + sw + se) / 32, 1.0f);
      const float scale = 1 / (std::min(std::abs(dx), std::abs(dy)) + reduce);
      dx = std::clamp(dx * scale, -kLongest_px, kLongest_px);
      dy = std::clamp(dy * scale, -kLongest_px, kLongest_px);
      const auto px = static_cast<float>(x), py = static_cast<float>(y);
      const auto pair = [&](float t) {
        return mean(sample(before, px - t * dx, py - t * dy), sample(before, px + t * dx, py + t * dy));
      };
      const Mean narrow = pair(1.0f / 6), wide = mean(narrow, pair(0.5f));
      const float wide_light = brightness(wide);
      const bool strayed = wide_light < static_cast<float>(low) || wide_light > static_cast<float>(high);
      const Mean& mixed = strayed ? narrow : wide;
      std::uint8_t* out = &image.rgb[3 * (y * width + x)];
      for (std::size_t c = 0; c < 3; ++c) out[c] = static_cast<std::uint8_t>(std::lround(mixed[c]));
    }
  }
}

}  // namespace onemap::render
