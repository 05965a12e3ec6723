#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>

#include "ink.hpp"
#include "render/compare.hpp"
#include "render/drawing.hpp"
#include "render/figures.hpp"
#include "render/legend.hpp"
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

struct Fitted {
  std::vector<Camera> cameras;
  std::vector<std::size_t> alike;  // that look in the direction in which the whole is seen
};

Fitted fit_each(std::span<const Scene> maps, std::span<const float> aspects, const Scene* whole) {
  Fitted out;
  out.cameras.reserve(maps.size());
  const Camera common = whole != nullptr ? make_camera(*whole, View::fit, kPictureAspect) : Camera{};
  const glm::vec3 forward = common.target - common.eye;
  for (std::size_t i = 0; i < maps.size(); ++i) {
    const auto T_whole_map = whole != nullptr ? motion_between(*whole, maps[i]) : std::nullopt;
    if (!T_whole_map) {
      out.cameras.push_back(make_camera(maps[i], View::fit, aspects[i]));
      continue;
    }
    const auto here = [&](const glm::vec3& v) {
      return to_glm(mapping::Vector3d(T_whole_map->R.transpose() * mapping::Vector3d(v.x, v.y, v.z)));
    };
    out.cameras.push_back(fit_along(maps[i], here(forward), here(common.up), aspects[i]));
    out.alike.push_back(i);
  }
  return out;
}

// At one scale a wide map needs more of its row than a narrow one: of each the room that it takes, times as far as it
// must be seen from there, are shares in which all are as far.
void share_row(std::span<float> aspects, std::span<const Camera> cameras) {
  constexpr float kLeastShare = 0.5f;  // of an even one: a name fits
  const auto even = std::accumulate(aspects.begin(), aspects.end(), 0.0f) / static_cast<float>(aspects.size());
  float sum = 0;
  for (std::size_t i = 0; i < aspects.size(); ++i) {
    aspects[i] *= glm::distance(cameras[i].eye, cameras[i].target);
    sum += aspects[i];
  }
  float wide = 0;
  for (float& aspect : aspects) {
    aspect = std::max(aspect * even * static_cast<float>(aspects.size()) / sum, kLeastShare * even);
    wide += aspect;
  }
  for (float& aspect : aspects) aspect *= even * static_cast<float>(aspects.size()) / wide;
}

}  // namespace

std::vector<float> aspects_beside(std::span<const Scene> maps, float aspect, std::size_t columns, const Scene* whole) {
  constexpr int kRounds = 2;
  std::vector<float> aspects(maps.size(), aspect);
  for (int round = 0; whole != nullptr && round < kRounds; ++round) {
    const Fitted fitted = fit_each(maps, aspects, whole);
    if (fitted.alike.size() < maps.size()) return aspects;
    for (std::size_t first = 0; first < maps.size(); first += columns) {
      const std::size_t count = std::min(columns, maps.size() - first);
      share_row(std::span(aspects).subspan(first, count), std::span(fitted.cameras).subspan(first, count));
    }
  }
  return aspects;
}

std::vector<Camera> cameras_beside(std::span<const Scene> maps, std::span<const float> aspects, const Scene* whole) {
  Fitted fitted = fit_each(maps, aspects, whole);
  float farthest_m = 0;
  for (const std::size_t i : fitted.alike)
    farthest_m = std::max(farthest_m, glm::distance(fitted.cameras[i].eye, fitted.cameras[i].target));
  for (const std::size_t i : fitted.alike) step_back(fitted.cameras[i], farthest_m);
  return fitted.cameras;
}

Result<Image> draw_side_by_side(Renderer& renderer, std::span<const Scene> maps, const Style& style, const Scene* whole,
                                bool plain) {
  if (maps.empty()) return Error{"picture", "no maps to put beside each other"};
  const int count = static_cast<int>(maps.size());
  const int columns = best_columns(count, style);
  const int rows = (count + columns - 1) / columns;
  Image picture(style.width_px, style.height_px, style.background);
  Style tile = style;
  const int even = style.width_px / columns;
  const int high = style.height_px / rows, caption = std::max(20, high / 10);
  tile.height_px = high - caption;
  if (even < 16 || tile.height_px < 8)
    return Error{"picture",
                 fmt::format("{} x {} pixels are too few for {} maps", style.width_px, style.height_px, count)};
  const float smaller = std::clamp(static_cast<float>(even) / 900, 0.7f, 1.0f);  // ways do not hide the map
  tile.path_width_px *= smaller;
  tile.marker_width_px *= smaller;
  const auto tall = static_cast<float>(tile.height_px), text = 0.34f * static_cast<float>(caption);
  const std::vector<float> aspects =
      aspects_beside(maps, static_cast<float>(even) / tall, static_cast<std::size_t>(columns), whole);
  const std::vector<Camera> cameras = cameras_beside(maps, aspects, whole);
  int x = 0;
  for (int i = 0; i < count; ++i, x += tile.width_px) {
    const auto at = static_cast<std::size_t>(i);
    const Scene& scene = maps[at];
    tile.width_px = std::max(static_cast<int>(aspects[at] * tall), 1);
    auto image = renderer.draw(scene, cameras[at], tile);
    if (!image) return image.error();
    if (!plain) draw_bar(*image, cameras[at]);
    if (i % columns == 0) x = 0;
    const int y = i / columns * high;
    paste(picture, *image, x, y);
    const auto wide = static_cast<float>(tile.width_px);
    const float middle = static_cast<float>(x) + 0.5f * wide, base = static_cast<float>(y + tile.height_px);
    draw_centred(picture, {middle, base + 1.1f * text}, 0.9f * wide, scene.title, text, kInk);
    draw_centred(picture, {middle, base + 2.5f * text}, 0.9f * wide, contents(scene), 0.8f * text, kSoftInk);
  }
  return picture;
}

}  // namespace onemap::render
