#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "ink.hpp"
#include "render/compare.hpp"
#include "render/drawing.hpp"
#include "render/figures.hpp"
#include "render/upright.hpp"
#include "vectors.hpp"

namespace onemap::render {
namespace {

constexpr float kPictureAspect = 16.0f / 9;  // of the picture of the whole that robots make

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

// Straight back from its target, to that distance.
void step_back(Camera& camera, float distance_m) {
  const glm::vec3 way = camera.eye - camera.target;
  const float more = distance_m - glm::length(way);
  camera.eye += more * glm::normalize(way);
  camera.far_m += more;
}

}  // namespace

std::vector<Camera> cameras_beside(std::span<const Scene> maps, float aspect, const Scene* whole) {
  std::vector<Camera> cameras;
  cameras.reserve(maps.size());
  std::vector<Camera*> alike;
  const Camera common = whole != nullptr ? make_camera(*whole, View::fit, kPictureAspect) : Camera{};
  const glm::vec3 forward = common.target - common.eye;
  float farthest_m = 0;
  for (const Scene& map : maps) {
    const auto T_whole_map = whole != nullptr ? motion_between(*whole, map) : std::nullopt;
    if (!T_whole_map) {
      cameras.push_back(make_camera(map, View::fit, aspect));
      continue;
    }
    const auto here = [&](const glm::vec3& v) {
      return to_glm(mapping::Vector3d(T_whole_map->R.transpose() * mapping::Vector3d(v.x, v.y, v.z)));
    };
    cameras.push_back(fit_along(map, here(forward), here(common.up), aspect));
    alike.push_back(&cameras.back());
    farthest_m = std::max(farthest_m, glm::distance(cameras.back().eye, cameras.back().target));
  }
  for (Camera* camera : alike) step_back(*camera, farthest_m);
  return cameras;
}

Result<Image> draw_side_by_side(Renderer& renderer, std::span<const Scene> maps, const Style& style,
                                const Scene* whole) {
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
  const std::vector<Camera> cameras = cameras_beside(maps, wide / static_cast<float>(tile.height_px), whole);
  for (int i = 0; i < count; ++i) {
    const Scene& scene = maps[static_cast<std::size_t>(i)];
    auto image = renderer.draw(scene, cameras[static_cast<std::size_t>(i)], tile);
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
