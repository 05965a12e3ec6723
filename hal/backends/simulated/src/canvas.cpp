#include "canvas.hpp"

#include <algorithm>
#include <cmath>

namespace onemap::hal::simulated {

namespace {

float lattice(std::uint64_t key, int x, int y) {
  const auto place = (static_cast<std::uint64_t>(static_cast<std::uint32_t>(x)) << 32) | static_cast<std::uint32_t>(y);
  return static_cast<float>(hash(key ^ hash(place)) >> 40) * 0x1p-23f - 1.0f;
}

// Is (a, b), in half sizes from the middle, inside?
bool inside(Mark mark, double a, double b, std::uint64_t glyph) {
  const double aa = a < 0 ? -a : a, bb = b < 0 ? -b : b;
  if (aa > 1 || bb > 1) return false;
  switch (mark) {
    case Mark::disc:
      return a * a + b * b < 1;
    case Mark::ring:
      return a * a + b * b < 1 && a * a + b * b > 0.3;
    case Mark::box:
      return true;
    case Mark::triangle:
      return b < 1 - 2 * aa;
    case Mark::cross:
      return aa < 0.3 || bb < 0.3;
    case Mark::stripes:
      return (static_cast<int>((a + 1) * 2.4999) & 1) == 0;
    case Mark::glyph: {
      const int column = static_cast<int>((a + 1) * 2.4999), row = static_cast<int>((b + 1) * 2.4999);
      return ((glyph >> (row * 5 + column)) & 1) != 0;
    }
  }
  return false;
}

}  // namespace

Canvas::Canvas(double width_m, double height_m, double texel_m, double brightness)
    : texel_m_(texel_m),
      width_(std::max(4, static_cast<int>(std::ceil(width_m / texel_m)))),
      height_(std::max(4, static_cast<int>(std::ceil(height_m / texel_m)))),
      values_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), static_cast<float>(brightness)) {}

void Canvas::add_noise(Random& random, double cell_m, double stretch, int octaves, double amplitude) {
  double cell = cell_m / texel_m_;
  for (int i = 0; i < octaves && cell * std::min(1.0, stretch) >= 1.5; ++i) {
    add_octave(random.next(), cell * stretch, cell, amplitude);
    cell /= 2;
    amplitude *= 0.6;
  }
}

void Canvas::add_octave(std::uint64_t key, double cell_u, double cell_v, double amplitude) {
  const auto step_u = static_cast<float>(1 / cell_u);
  for (int y = 0; y < height_; ++y) {
    const double v = y / cell_v;
    const int j = static_cast<int>(v);
    const auto fv = static_cast<float>(v - j);
    const float sv = fv * fv * (3 - 2 * fv);
    const auto between = [&](int i) {
      const float low = lattice(key, i, j);
      return static_cast<float>(amplitude) * (low + sv * (lattice(key, i, j + 1) - low));
    };
    int cell = 0;
    float left = between(0), right = between(1);
    for (int x = 0; x < width_; ++x) {
      const float u = static_cast<float>(x) * step_u;
      if (u >= static_cast<float>(cell + 1)) {
        ++cell;
        left = right;
        right = between(cell + 1);
      }
      const float fu = u - static_cast<float>(cell);
      at(x, y) += left + fu * fu * (3 - 2 * fu) * (right - left);
    }
  }
}

void Canvas::add_grain(Random& random, double amplitude) {
  std::uint64_t state = random.next() | 1u;
  const auto scale = static_cast<float>(amplitude * 0x1p-31);
  for (float& value : values_) {
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    value += scale * static_cast<float>(static_cast<std::int32_t>(state >> 32));
  }
}

void Canvas::fill(double u0, double v0, double u1, double v1, double brightness) {
  stamp(Mark::box, (u0 + u1) / 2, (v0 + v1) / 2, (u1 - u0) / 2, (v1 - v0) / 2, 0, brightness, 0);
}

void Canvas::shift(double u0, double v0, double u1, double v1, double difference) {
  const int x0 = std::max(0, static_cast<int>(u0 / texel_m_)), x1 = std::min(width_, static_cast<int>(u1 / texel_m_));
  const int y0 = std::max(0, static_cast<int>(v0 / texel_m_)), y1 = std::min(height_, static_cast<int>(v1 / texel_m_));
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) at(x, y) += static_cast<float>(difference);
}

void Canvas::stamp(Mark mark, double u, double v, double half_u, double half_v, double turns, double brightness,
                   std::uint64_t glyph) {
  const double c = cos_turns(turns), s = sin_turns(turns);
  const double reach_u = std::abs(half_u * c) + std::abs(half_v * s),
               reach_v = std::abs(half_u * s) + std::abs(half_v * c);
  const int x0 = std::max(0, static_cast<int>((u - reach_u) / texel_m_)),
            y0 = std::max(0, static_cast<int>((v - reach_v) / texel_m_));
  const int x1 = std::min(width_ - 1, static_cast<int>((u + reach_u) / texel_m_) + 1);
  const int y1 = std::min(height_ - 1, static_cast<int>((v + reach_v) / texel_m_) + 1);
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const double du = (x + 0.5) * texel_m_ - u, dv = (y + 0.5) * texel_m_ - v;
      if (!inside(mark, (c * du + s * dv) / half_u, (c * dv - s * du) / half_v, glyph)) continue;
      at(x, y) += 0.85f * (static_cast<float>(brightness) - at(x, y));  // what lies below shows a little
    }
  }
}

void Canvas::text(Random& random, double u0, double v0, double u1, double v1, double letter_m, double brightness) {
  double v = v1 - letter_m;
  while (v > v0) {
    const double end = u0 + (u1 - u0) * random.range(0.5, 1.0);
    double u = u0 + letter_m / 2;
    while (u < end) {
      if (!random.chance(0.18)) stamp(Mark::glyph, u, v, letter_m / 2, letter_m / 2, 0, brightness, random.next());
      u += 1.25 * letter_m;
    }
    v -= 1.7 * letter_m;
  }
}

std::vector<std::uint8_t> Canvas::bytes() const {
  std::vector<std::uint8_t> out(values_.size());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<std::uint8_t>(std::clamp(values_[i], 0.0f, 255.0f));
  return out;
}

}  // namespace onemap::hal::simulated
