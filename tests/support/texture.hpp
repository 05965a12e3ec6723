#pragma once
#include <cmath>
#include <cstdint>
#include <vector>

#include "mapping/image.hpp"

namespace onemap::test {

// A grey image with its pixels, seen as the mapping code sees one.
struct GreyImage {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;
  mapping::GrayView view() const { return {pixels.data(), width, height, width}; }
};

inline std::uint32_t hash(std::uint32_t x, std::uint32_t y, std::uint32_t seed) {
  std::uint32_t h = seed + x * 0x9E3779B1u + y * 0x85EBCA77u;
  h = (h ^ (h >> 15)) * 0x2C1B3C6Du;
  h = (h ^ (h >> 12)) * 0x297A2D39u;
  return h ^ (h >> 15);
}

// Smooth noise over the whole plane, 0..1, one random value every `cell`.
inline double value_noise(double x, double y, double cell, std::uint32_t seed) {
  const double u = x / cell + 1000, v = y / cell + 1000;
  const double iu = std::floor(u), iv = std::floor(v);
  const auto smooth = [](double t) { return t * t * (3 - 2 * t); };
  const double fu = smooth(u - iu), fv = smooth(v - iv);
  const auto at = [&](int dx, int dy) {
    return hash(static_cast<std::uint32_t>(iu) + static_cast<std::uint32_t>(dx),
                static_cast<std::uint32_t>(iv) + static_cast<std::uint32_t>(dy), seed) /
           4294967295.0;
  };
  return (at(0, 0) * (1 - fu) + at(1, 0) * fu) * (1 - fv) + (at(0, 1) * (1 - fu) + at(1, 1) * fu) * fv;
}

inline double texture(double x, double y, std::uint32_t seed) {
  return 0.40 * value_noise(x, y, 9, seed) + 0.35 * value_noise(x, y, 21, seed + 1) +
         0.25 * value_noise(x, y, 45, seed + 2);
}

// Paints value(x, y), clamped to 0..255, at each pixel centre.
template <typename Value>
GreyImage paint(int width, int height, Value value) {
  GreyImage out{width, height, std::vector<std::uint8_t>(static_cast<std::size_t>(width * height))};
  std::size_t i = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      out.pixels[i++] = static_cast<std::uint8_t>(std::lround(std::fmin(255, std::fmax(0, value(x, y)))));
  return out;
}

// A similarity about the image centre: where a point of the textured plane is seen.
struct Similarity {
  double centre_x, centre_y, angle, scale;
  void to_image(double x, double y, double& u, double& v) const {
    const double dx = x - centre_x, dy = y - centre_y;
    u = centre_x + scale * (std::cos(angle) * dx - std::sin(angle) * dy);
    v = centre_y + scale * (std::sin(angle) * dx + std::cos(angle) * dy);
  }
  void from_image(double u, double v, double& x, double& y) const {
    const double dx = (u - centre_x) / scale, dy = (v - centre_y) / scale;
    x = centre_x + std::cos(angle) * dx + std::sin(angle) * dy;
    y = centre_y - std::sin(angle) * dx + std::cos(angle) * dy;
  }
};

inline GreyImage textured(int width, int height, std::uint32_t seed, const Similarity* warp = nullptr) {
  return paint(width, height, [&](double u, double v) {
    double x = u, y = v;
    if (warp != nullptr) warp->from_image(u, v, x, y);
    return 255 * texture(x, y, seed);
  });
}

}  // namespace onemap::test
