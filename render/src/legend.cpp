#include "render/legend.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "ink.hpp"
#include "render/drawing.hpp"
#include "render/upright.hpp"
#include "vectors.hpp"

namespace onemap::render {
namespace {

constexpr Color kPaper{255, 255, 255}, kGrid{40, 60, 90};
constexpr std::array<Color, 3> kAxes{{{205, 50, 45}, {40, 150, 60}, {45, 95, 215}}};
constexpr float kPaperOpacity = 0.72f;

// Sizes in a picture, by its height.
struct Sizes {
  explicit Sizes(const Image& image)
      : text(std::max(7.0f, static_cast<float>(image.height) * 12 / 720)), line(2.1f * text), border(1.2f * text) {}
  float text, line, border;  // height of capitals, from line to line, from the picture's rim
};

int whole(float x) { return static_cast<int>(std::lround(x)); }

void draw_names(Image& image, const Scene& scene, const Sizes& sizes) {
  if (scene.robots.empty()) return;
  float widest = 0;
  for (const RobotPath& robot : scene.robots) widest = std::max(widest, text_width_px(robot.name, sizes.text));
  const float count = static_cast<float>(scene.robots.size());
  const float left = sizes.border, top = sizes.border, sample = 2.2f * sizes.text, gap = 0.8f * sizes.text;
  fill_rectangle(image, whole(left), whole(top), whole(sample + widest + 3.6f * gap),
                 whole((count - 1) * sizes.line + sizes.text + 1.8f * gap), kPaper, kPaperOpacity);
  float y = top + 0.9f * gap + sizes.text;
  for (const RobotPath& robot : scene.robots) {
    const float middle = y - 0.5f * sizes.text;
    draw_line(image, {left + gap, middle}, {left + gap + sample, middle}, robot.color, 0.3f * sizes.text);
    fill_disc(image, {left + gap + sample, middle}, 0.38f * sizes.text, robot.color);
    draw_text(image, {left + 2.6f * gap + sample, y}, robot.name, sizes.text, kInk);
    y += sizes.line;
  }
}

// A metre, or a part or a multiple of it, that fits: what it is and what to call it.
struct Bar {
  float length_m;
  const char* name;
};
Bar fitting_bar(float metre_px, float picture_px) {
  constexpr std::array<Bar, 5> kBars{{{0.1f, "10 cm"}, {0.5f, "50 cm"}, {1, "1 m"}, {5, "5 m"}, {20, "20 m"}}};
  const auto fits = [&](const Bar& bar) {
    return bar.length_m * metre_px <= 0.35f * picture_px && bar.length_m * metre_px >= 0.03f * picture_px;
  };
  if (fits(kBars[2])) return kBars[2];
  const auto found = std::ranges::find_if(kBars, fits);
  return found != kBars.end() ? *found : kBars[2];
}

// x, y (up), z of the upright frame as seen by the camera.
void draw_axes(Image& image, const Scene& scene, const Camera& camera, const Sizes& sizes) {
  const mapping::Matrix3d R = upright_rotation(up_of(scene));
  const glm::mat4 view = camera.view();
  const float length = 2.6f * sizes.text;
  const Point origin{sizes.border + 1.6f * length, static_cast<float>(image.height) - sizes.border - 1.6f * length};
  fill_disc(image, origin, 1.55f * length, kPaper, kPaperOpacity);
  std::array<std::size_t, 3> order{0, 1, 2};
  std::array<glm::vec3, 3> seen;
  for (std::size_t i = 0; i < 3; ++i) {
    const mapping::Vector3d axis = R.row(static_cast<Eigen::Index>(i)).transpose();
    seen[i] = glm::vec3(view * glm::vec4(to_glm(axis), 0.0f));
  }
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return seen[a].z < seen[b].z; });
  for (const std::size_t i : order) {  // the farthest first
    const Point tip{origin.x + length * seen[i].x, origin.y - length * seen[i].y};
    draw_line(image, origin, tip, kAxes[i], 0.22f * sizes.text);
    const float reach = std::max(std::hypot(seen[i].x, seen[i].y), 1e-3f);
    const float beyond = length * reach + 0.8f * sizes.text;
    const Point at{origin.x + beyond * seen[i].x / reach, origin.y - beyond * seen[i].y / reach};
    const std::string_view name = std::string_view("xyz").substr(i, 1);
    const float small = 0.8f * sizes.text;
    draw_text(image, {at.x - 0.5f * text_width_px(name, small), at.y + 0.35f * small}, name, small, kAxes[i]);
  }
}

// Lines through every metre from the eye's foot, each fifth stronger, numbered along the lower and left rims.
void draw_grid(Image& image, const Camera& camera, const Sizes& sizes) {
  const float metre_px = 1 / camera.metres_per_pixel(camera.target, image.height);
  const float small = 0.75f * sizes.text;
  const auto w = static_cast<float>(image.width), h = static_cast<float>(image.height);
  const int step = std::max(1, whole(std::ceil(3.2f * sizes.text / metre_px)));
  const auto line = [&](float at, bool upright, int number) {
    const bool strong = number % 5 == 0;
    draw_line(image, upright ? Point{at, 0} : Point{0, at}, upright ? Point{at, h - 1} : Point{w - 1, at}, kGrid,
              strong ? 1.4f : 1.0f, strong ? 0.4f : 0.2f);
    const std::string text = fmt::format("{}", number);
    const float wide = text_width_px(text, small);
    const Point place = upright ? Point{at - 0.5f * wide, h - 0.6f * small} : Point{0.6f * small, at + 0.5f * small};
    fill_rectangle(image, whole(place.x - 2), whole(place.y - small - 2), whole(wide + 5), whole(small + 5), kPaper,
                   kPaperOpacity);
    draw_text(image, place, text, small, kInk);
  };
  const int columns = static_cast<int>(0.5f * w / metre_px), rows = static_cast<int>(0.5f * h / metre_px);
  for (int i = -columns / step * step; i <= columns; i += step)
    line(0.5f * w + static_cast<float>(i) * metre_px, true, i);
  for (int i = -rows / step * step; i <= rows; i += step) line(0.5f * h - static_cast<float>(i) * metre_px, false, i);
}

}  // namespace

void draw_bar(Image& image, const Camera& camera) {
  const Sizes sizes(image);
  const float metre_px = 1 / camera.metres_per_pixel(camera.target, image.height);
  const Bar bar = fitting_bar(metre_px, static_cast<float>(image.width));
  const float length = bar.length_m * metre_px, gap = 0.8f * sizes.text;
  const float right = static_cast<float>(image.width) - sizes.border - gap, left = right - length;
  const float y = static_cast<float>(image.height) - sizes.border - gap, tick = 0.45f * sizes.text;
  const float text = text_width_px(bar.name, sizes.text), wide = std::max(length, text);
  fill_rectangle(image, whole(right - wide - gap), whole(y - 2.2f * sizes.text - gap), whole(wide + 2 * gap),
                 whole(2.2f * sizes.text + 2 * gap), kPaper, kPaperOpacity);
  draw_line(image, {left, y}, {right, y}, kInk, 0.18f * sizes.text);
  for (const float x : {left, right}) draw_line(image, {x, y - tick}, {x, y + tick}, kInk, 0.18f * sizes.text);
  draw_text(image, {right - 0.5f * (wide + text), y - sizes.text}, bar.name, sizes.text, kInk);
}

void draw_legend(Image& image, const Scene& scene, const Camera& camera) {
  const Sizes sizes(image);
  if (camera.height_m > 0) draw_grid(image, camera, sizes);
  draw_names(image, scene, sizes);
  draw_bar(image, camera);
  if (camera.height_m <= 0) draw_axes(image, scene, camera, sizes);
}

Result<Image> take_picture(Renderer& renderer, const Scene& scene, const Camera& camera, const Style& style,
                           bool plain) {
  auto image = renderer.draw(scene, camera, style);
  if (image && !plain) draw_legend(*image, scene, camera);
  return image;
}

}  // namespace onemap::render
