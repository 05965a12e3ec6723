#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

namespace onemap::hal::simulated {

// One surface's brightness as a pyramid of halved images (one byte a texel), and the colours that brightness stands
// for.
class Texture {
 public:
  static constexpr int kMaxLevels = 12;

  // base: width x height values, row by row; both at least 2.
  Texture(const std::vector<std::uint8_t>& base, int width, int height, double texel_m);

  // Brightness 0..255 at (u, v), given in 1/256 texels of the base level from its corner, between the two levels around
  // level8 (in 1/256 levels). Coordinates outside are held at the edge.
  int sample(int u256, int v256, int level8) const {
    level8 = std::clamp(level8, 0, max_level8_);
    const int level = level8 >> 8, part = level8 & 255;
    const int fine = bilinear(level, u256, v256);
    if (part == 0) return fine >> 8;
    return (fine * (256 - part) + bilinear(level + 1, u256, v256) * part) >> 16;
  }

  double texel_m() const { return texel_m_; }
  std::size_t bytes() const { return texels_.size(); }

  // Per brightness: red, green, blue in the low bytes, light included; kDark is set where an infrared pattern would
  // not come back.
  std::array<std::uint32_t, 256> colours{};
  static constexpr std::uint32_t kDark = 1u << 24;

 private:
  struct Level {
    std::size_t offset = 0;
    int width = 0, height = 0;
  };

  int bilinear(int level, int u256, int v256) const {
    const Level& l = levels_[static_cast<std::size_t>(level)];
    const int u = std::clamp((u256 >> level) - 128, 0, l.width * 256 - 257);
    const int v = std::clamp((v256 >> level) - 128, 0, l.height * 256 - 257);
    const int fu = u & 255, fv = v & 255;
    const std::uint8_t* p = texels_.data() + l.offset + (v >> 8) * l.width + (u >> 8);
    const std::uint8_t* q = p + l.width;
    const int top = p[0] * 256 + (p[1] - p[0]) * fu, bottom = q[0] * 256 + (q[1] - q[0]) * fu;
    return (top * 256 + (bottom - top) * fv) >> 8;
  }

  void add_level(const Level& from);

  std::vector<std::uint8_t> texels_;
  std::array<Level, kMaxLevels> levels_{};
  int max_level8_ = 0;
  double texel_m_;
};

// log2 in 1/256 from the float's bits, straight between powers of two (off by at most 0.09): enough to choose a level.
inline int coarse_log2_256(float x) { return (std::bit_cast<std::int32_t>(x) >> 15) - (127 << 8); }

}  // namespace onemap::hal::simulated
