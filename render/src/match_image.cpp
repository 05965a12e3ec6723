#include "render/match_image.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace onemap::render {
namespace {

using Color = std::array<std::uint8_t, 3>;
constexpr Color kKept{30, 220, 60}, kRejected{235, 40, 40}, kFeature{255, 210, 0};

void blend(Image& image, int x, int y, Color color, float alpha) {
  if (x < 0 || y < 0 || x >= image.width || y >= image.height || alpha <= 0) return;
  Color pixel = image.at(x, y);
  for (std::size_t c = 0; c < 3; ++c) {
    const float mixed = static_cast<float>(pixel[c]) * (1 - alpha) + static_cast<float>(color[c]) * alpha;
    pixel[c] = static_cast<std::uint8_t>(std::lround(mixed));
  }
  image.set(x, y, pixel);
}

// How much of a pixel a stroke of the given width covers whose middle is distance_px away.
float coverage(float distance_px, float width_px) {
  return std::clamp(0.5f * width_px + 0.5f - distance_px, 0.0f, 1.0f);
}

struct Point {
  float x = 0, y = 0;
};

void draw_line(Image& image, Point a, Point b, Color color, float width_px, float alpha) {
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
      blend(image, x, y, color, alpha * coverage(distance, width_px));
    }
  }
}

void draw_circle(Image& image, Point center, float radius_px, Color color, float width_px) {
  const int reach = static_cast<int>(radius_px + width_px) + 2;
  const int cx = static_cast<int>(std::lround(center.x)), cy = static_cast<int>(std::lround(center.y));
  for (int y = cy - reach; y <= cy + reach; ++y) {
    for (int x = cx - reach; x <= cx + reach; ++x) {
      const float dx = static_cast<float>(x) - center.x, dy = static_cast<float>(y) - center.y;
      blend(image, x, y, color, coverage(std::abs(std::sqrt(dx * dx + dy * dy) - radius_px), width_px));
    }
  }
}

void paste(Image& image, const MatchSide& side, int x0) {
  assert(side.rgb.size() == 3 * static_cast<std::size_t>(side.width) * static_cast<std::size_t>(side.height));
  const std::size_t row = 3 * static_cast<std::size_t>(side.width);
  for (int y = 0; y < side.height; ++y) {
    const auto from = side.rgb.subspan(static_cast<std::size_t>(y) * row, row);
    const std::size_t to =
        3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x0));
    std::copy(from.begin(), from.end(), image.rgb.begin() + static_cast<std::ptrdiff_t>(to));
  }
}

Point place(const MatchSide& side, std::size_t i, int x0) {
  const mapping::Keypoint& k = side.features.keypoints[i];
  return {k.x_px + static_cast<float>(x0), k.y_px};
}

}  // namespace

Image draw_matches(const MatchSide& left, const MatchSide& right, std::span<const mapping::Match> matches,
                   std::span<const std::uint8_t> kept) {
  assert(matches.size() == kept.size());
  Image image(left.width + right.width, std::max(left.height, right.height));
  paste(image, left, 0);
  paste(image, right, left.width);
  for (std::size_t i = 0; i < left.features.size(); ++i) draw_circle(image, place(left, i, 0), 2.5f, kFeature, 1);
  for (std::size_t i = 0; i < right.features.size(); ++i)
    draw_circle(image, place(right, i, left.width), 2.5f, kFeature, 1);
  for (const bool good : {false, true}) {
    const Color color = good ? kKept : kRejected;
    for (std::size_t i = 0; i < matches.size(); ++i) {
      if ((kept[i] != 0) != good) continue;
      const Point a = place(left, matches[i].a, 0), b = place(right, matches[i].b, left.width);
      draw_line(image, a, b, color, 1.2f, good ? 0.85f : 0.6f);
      draw_circle(image, a, 2.5f, color, 1.5f);
      draw_circle(image, b, 2.5f, color, 1.5f);
    }
  }
  return image;
}

}  // namespace onemap::render
