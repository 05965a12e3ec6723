#include "render/drawing.hpp"

#include <algorithm>
#include <cmath>

namespace onemap::render {
namespace {

void blend(Image& image, int x, int y, Color color, float opacity) {
  if (x < 0 || y < 0 || x >= image.width || y >= image.height || opacity <= 0) return;
  Color pixel = image.at(x, y);
  for (std::size_t c = 0; c < 3; ++c) {
    const float mixed = static_cast<float>(pixel[c]) * (1 - opacity) + static_cast<float>(color[c]) * opacity;
    pixel[c] = static_cast<std::uint8_t>(std::lround(mixed));
  }
  image.set(x, y, pixel);
}

// How much of a pixel a stroke of the given width covers whose middle is distance_px away.
float coverage(float distance_px, float width_px) {
  return std::clamp(0.5f * width_px + 0.5f - distance_px, 0.0f, 1.0f);
}

template <class Paint>
void around(Point center, float reach_px, const Paint& paint) {
  const int reach = static_cast<int>(reach_px) + 2;
  const int cx = static_cast<int>(std::lround(center.x)), cy = static_cast<int>(std::lround(center.y));
  for (int y = cy - reach; y <= cy + reach; ++y) {
    for (int x = cx - reach; x <= cx + reach; ++x) {
      const float dx = static_cast<float>(x) - center.x, dy = static_cast<float>(y) - center.y;
      paint(x, y, std::sqrt(dx * dx + dy * dy));
    }
  }
}

}  // namespace

void draw_line(Image& image, Point a, Point b, Color color, float width_px, float opacity) {
  const float dx = b.x - a.x, dy = b.y - a.y;
  const float length = std::max(std::sqrt(dx * dx + dy * dy), 1e-6f);
  // Walk along the longer axis and paint the few pixels across it.
  const bool steep = std::abs(dy) > std::abs(dx);
  const float main_a = steep ? a.y : a.x, main_b = steep ? b.y : b.x;
  const float slope = steep ? dx / dy : (dx != 0 ? dy / dx : 0);
  const int reach = static_cast<int>(std::ceil(width_px)) + 1;
  const int first = static_cast<int>(std::lround(std::min(main_a, main_b)));
  const int last = static_cast<int>(std::lround(std::max(main_a, main_b)));
  for (int m = first; m <= last; ++m) {
    const float across = (steep ? a.x : a.y) + (static_cast<float>(m) - main_a) * slope;
    const int middle = static_cast<int>(std::lround(across));
    for (int s = middle - reach; s <= middle + reach; ++s) {
      const int x = steep ? s : m, y = steep ? m : s;
      const float distance = std::abs((static_cast<float>(x) - a.x) * dy - (static_cast<float>(y) - a.y) * dx) / length;
      blend(image, x, y, color, opacity * coverage(distance, width_px));
    }
  }
}

void draw_circle(Image& image, Point center, float radius_px, Color color, float width_px) {
  around(center, radius_px + width_px, [&](int x, int y, float distance) {
    blend(image, x, y, color, coverage(std::abs(distance - radius_px), width_px));
  });
}

void fill_disc(Image& image, Point center, float radius_px, Color color, float opacity) {
  around(center, radius_px,
         [&](int x, int y, float distance) { blend(image, x, y, color, opacity * coverage(distance, 2 * radius_px)); });
}

void fill_rectangle(Image& image, int x, int y, int width, int height, Color color, float opacity) {
  const int x1 = std::min(x + width, image.width), y1 = std::min(y + height, image.height);
  for (int py = std::max(y, 0); py < y1; ++py)
    for (int px = std::max(x, 0); px < x1; ++px) blend(image, px, py, color, opacity);
}

void paste(Image& onto, const Image& picture, int x, int y) {
  const int x0 = std::max(0, -x), x1 = std::min(picture.width, onto.width - x);
  const int y0 = std::max(0, -y), y1 = std::min(picture.height, onto.height - y);
  for (int py = y0; py < y1; ++py)
    for (int px = x0; px < x1; ++px) onto.set(x + px, y + py, picture.at(px, py));
}

}  // namespace onemap::render
