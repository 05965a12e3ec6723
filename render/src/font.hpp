#pragma once
#include <string_view>
#include <vector>

#include "render/drawing.hpp"

namespace onemap::render {

// A glyph of the stroke font: lines in units of a twelfth of a capital's height, x right from its left edge, y up from
// the base line.
struct Glyph {
  std::vector<std::vector<Point>> lines;
  float advance = 0;  // to the next glyph
};
Glyph glyph_of(char character);

}  // namespace onemap::render
