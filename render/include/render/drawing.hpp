#pragma once
#include <string_view>

#include "render/image.hpp"

namespace onemap::render {

using Color = std::array<std::uint8_t, 3>;

// A place in a picture, pixels from the middle of its upper left pixel; x right, y down. Everything below is smooth-
// edged, may reach over the rim, and takes opacity 0..1.
struct Point {
  float x = 0, y = 0;
};

void draw_line(Image& image, Point a, Point b, Color color, float width_px, float opacity = 1);
void draw_circle(Image& image, Point center, float radius_px, Color color, float width_px);
void fill_disc(Image& image, Point center, float radius_px, Color color, float opacity = 1);
// From x, y on; parts outside the picture are left out.
void fill_rectangle(Image& image, int x, int y, int width, int height, Color color, float opacity = 1);
// Copies a picture so that its upper left pixel comes to x, y; parts outside are left out.
void paste(Image& onto, const Image& picture, int x, int y);

// Text in the built-in stroke font: ASCII; what it lacks is a box. `at` is the left end of the base line, height_px
// that of a capital. Letters reach a third of the height below the line.
void draw_text(Image& image, Point at, std::string_view text, float height_px, Color color);
float text_width_px(std::string_view text, float height_px);

}  // namespace onemap::render
