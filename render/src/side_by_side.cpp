#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ink.hpp"
#include "render/drawing.hpp"
#include "render/figures.hpp"

namespace onemap::render {
namespace {

std::string with_thousands(std::size_t n) {
  if (n < 1000) return fmt::format("{}", n);
  return fmt::format("{} {:03}", with_thousands(n / 1000), n % 1000);
}

std::string contents(const Scene& scene) {
  if (!scene.mesh.triangles.empty()) return with_thousands(scene.mesh.triangles.size()) + " triangles";
  return with_thousands(std::max(scene.mesh.vertices.size(), scene.points.points.size())) + " points";
}

// As large as it may be and no wider than `room_px`.
void draw_centred(Image& image, Point middle, float room_px, const std::string& text, float height_px, Color color) {
  const float fit = std::min(1.0f, room_px / std::max(text_width_px(text, height_px), 1.0f)) * height_px;
  draw_text(image, {middle.x - 0.5f * text_width_px(text, fit), middle.y}, text, fit, color);
}

// With which the maps, a third wider than high, are largest.
int best_columns(int count, const Style& style) {
  int best = 1, best_size = 0;
  for (int columns = 1; columns <= count; ++columns) {
    const int rows = (count + columns - 1) / columns;
    const int size = std::min(style.width_px / columns * 3 / 4, style.height_px / rows * 9 / 10);
    if (size <= best_size) continue;
    best_size = size;
    best = columns;
  }
  return best;
}

}  // namespace

Result<Image> draw_side_by_side(Renderer& renderer, std::span<const Scene> maps, const Style& style) {
  if (maps.empty()) return Error{"picture", "no maps to put beside each other"};
  const int count = static_cast<int>(maps.size());
  const int columns = best_columns(count, style);
  const int rows = (count + columns - 1) / columns;
  Image picture(style.width_px, style.height_px, style.background);
  Style tile = style;
  tile.width_px = style.width_px / columns;
  const int high = style.height_px / rows, caption = std::max(20, high / 10);
  tile.height_px = high - caption;
  if (tile.width_px < 8 || tile.height_px < 8)
    return Error{"picture",
                 fmt::format("{} x {} pixels are too few for {} maps", style.width_px, style.height_px, count)};
  const float smaller = std::clamp(static_cast<float>(tile.width_px) / 900, 0.7f, 1.0f);  // ways do not hide the map
  tile.path_width_px *= smaller;
  tile.marker_width_px *= smaller;
  const auto wide = static_cast<float>(tile.width_px), text = 0.34f * static_cast<float>(caption);
  for (int i = 0; i < count; ++i) {
    const Scene& scene = maps[static_cast<std::size_t>(i)];
    const Camera camera = make_camera(scene, View::fit, wide / static_cast<float>(tile.height_px));
    auto image = renderer.draw(scene, camera, tile);
    if (!image) return image.error();
    const int x = i % columns * tile.width_px, y = i / columns * high;
    paste(picture, *image, x, y);
    const float middle = static_cast<float>(x) + 0.5f * wide, base = static_cast<float>(y + tile.height_px);
    draw_centred(picture, {middle, base + 1.1f * text}, 0.9f * wide, scene.title, text, kInk);
    draw_centred(picture, {middle, base + 2.5f * text}, 0.9f * wide, contents(scene), 0.8f * text, kSoftInk);
  }
  return picture;
}

}  // namespace onemap::render
