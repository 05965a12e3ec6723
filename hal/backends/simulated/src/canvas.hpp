#pragma once
#include <cstdint>
#include <vector>

#include "arithmetic.hpp"

namespace onemap::hal::simulated {

enum class Mark { disc, ring, box, triangle, cross, stripes, glyph };
constexpr int kMarks = 7;

// A brightness image that is being painted, in metres from its lower left corner; brightness 0..255.
class Canvas {
 public:
  Canvas(double width_m, double height_m, double texel_m, double brightness);

  // Adds value noise: octaves of halving cell size (cell_m at first; stretch times as long along u), the first
  // within +-amplitude, each next one 0.6 of it.
  void add_noise(Random& random, double cell_m, double stretch, int octaves, double amplitude);
  // Adds +-amplitude to each texel alone.
  void add_grain(Random& random, double amplitude);
  void fill(double u0, double v0, double u1, double v1, double brightness);
  void shift(double u0, double v0, double u1, double v1, double difference);
  // One shape of the given half sizes, turned, over what is there.
  void stamp(Mark mark, double u, double v, double half_u, double half_v, double turns, double brightness,
             std::uint64_t glyph);
  // Rows of small glyphs in a rectangle.
  void text(Random& random, double u0, double v0, double u1, double v1, double letter_m, double brightness);

  double width_m() const { return width_ * texel_m_; }
  double height_m() const { return height_ * texel_m_; }
  double texel_m() const { return texel_m_; }
  int width() const { return width_; }
  int height() const { return height_; }
  std::vector<std::uint8_t> bytes() const;

 private:
  float& at(int x, int y) {
    return values_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)];
  }
  void add_octave(std::uint64_t key, double cell_u, double cell_v, double amplitude);

  double texel_m_;
  int width_, height_;
  std::vector<float> values_;
};

}  // namespace onemap::hal::simulated
