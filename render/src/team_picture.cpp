#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ink.hpp"
#include "render/drawing.hpp"
#include "render/figures.hpp"

namespace onemap::render {
namespace {

constexpr Color kSheet{250, 250, 250}, kGood{60, 150, 80}, kBad{205, 65, 55};

constexpr float kCountAt = 0.28f;  // of a link's length: farther on others cross it

// Where things stand in a picture of a size.
struct Layout {
  Layout(const Image& image, std::size_t robots)
      : unit(static_cast<float>(std::min(image.height, image.width * 9 / 16)) / 720),
        centre{0.31f * static_cast<float>(image.width), 0.52f * static_cast<float>(image.height)},
        radius(std::min(0.31f * static_cast<float>(image.height), 0.2f * static_cast<float>(image.width))),
        count(robots) {}
  // The first at the top, then clockwise.
  Point robot(std::size_t i) const {
    const float turn = 6.2831853f * static_cast<float>(i) / static_cast<float>(std::max<std::size_t>(count, 1));
    return {centre.x + radius * std::sin(turn), centre.y - radius * std::cos(turn)};
  }
  float unit;
  Point centre;
  float radius;
  std::size_t count;
};

Point between(Point a, Point b, float t) { return {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)}; }

void draw_broken(Image& image, Point a, Point b, Color color, float width_px, float dash_px) {
  const float length = std::max(std::hypot(b.x - a.x, b.y - a.y), 1.0f);
  const int dashes = static_cast<int>(std::ceil(length / (2 * dash_px)));
  for (int i = 0; i < dashes; ++i) {
    const float at = 2 * dash_px * static_cast<float>(i);
    draw_line(image, between(a, b, at / length), between(a, b, std::min(at + dash_px, length) / length), color,
              width_px);
  }
}

void draw_centred(Image& image, Point middle, const std::string& text, float height_px, Color color) {
  draw_text(image, {middle.x - 0.5f * text_width_px(text, height_px), middle.y + 0.5f * height_px}, text, height_px,
            color);
}

void draw_link(Image& image, const Layout& at, const TeamPicture::Link& link) {
  const Point a = at.robot(link.a), b = at.robot(link.b);
  if (!link.accepted) return draw_broken(image, a, b, kBad, 2 * at.unit, 9 * at.unit);
  const float width = std::clamp(std::sqrt(static_cast<float>(link.inliers)) / 8, 2.0f, 12.0f);
  draw_line(image, a, b, kGood, width * at.unit);
}

void draw_count(Image& image, const Layout& at, const TeamPicture::Link& link) {
  if (!link.accepted) return;
  const Point middle = between(at.robot(link.a), at.robot(link.b), kCountAt);
  const std::string text = fmt::format("{}", link.inliers);
  const float height = 15 * at.unit, wide = text_width_px(text, height);
  fill_rectangle(image, static_cast<int>(middle.x - 0.5f * wide - 6 * at.unit),
                 static_cast<int>(middle.y - 0.9f * height), static_cast<int>(wide + 12 * at.unit),
                 static_cast<int>(1.8f * height), kSheet, 0.9f);
  draw_centred(image, middle, text, height, kGood);
}

void draw_robot(Image& image, const Layout& at, std::size_t i, const TeamPicture& team) {
  const TeamPicture::Robot& robot = team.robots[i];
  const Point place = at.robot(i);
  const float radius = 27 * at.unit;
  fill_disc(image, place, radius + 4 * at.unit, kSheet);
  fill_disc(image, place, radius, robot.color, robot.in_map ? 1.0f : 0.35f);
  if (robot.name == team.reference) draw_circle(image, place, radius + 6 * at.unit, kInk, 2 * at.unit);
  // Outwards of it, where no link is.
  const std::string keyframes = fmt::format("{} keyframes", robot.keyframes);
  const float name_px = 15 * at.unit, small_px = 11 * at.unit, beyond = radius + 12 * at.unit;
  const float half_wide = 0.5f * std::max(text_width_px(robot.name, name_px), text_width_px(keyframes, small_px));
  const float x = (place.x - at.centre.x) / at.radius, y = (place.y - at.centre.y) / at.radius;
  const Point block{place.x + x * (beyond + half_wide), place.y + y * (beyond + 18 * at.unit)};
  draw_centred(image, {block.x, block.y - 10 * at.unit}, robot.name, name_px, kInk);
  draw_centred(image, {block.x, block.y + 11 * at.unit}, keyframes, small_px, kSoftInk);
}

// In one line, as large as it may be.
void draw_link_words(Image& image, Point at, float height_px, const TeamPicture& team, const TeamPicture::Link& link) {
  const std::string pair = fmt::format("{} - {}:  ", team.robots[link.a].name, team.robots[link.b].name);
  const std::string words = link.accepted ? fmt::format("{} inliers of {} pairs of clouds", link.inliers, link.pairs)
                                          : "refused, " + link.reason;
  const float room = 0.98f * static_cast<float>(image.width) - at.x;
  const float height = height_px * std::min(1.0f, room / std::max(text_width_px(pair + words, height_px), 1.0f));
  draw_text(image, at, pair, height, kInk);
  draw_text(image, {at.x + text_width_px(pair, height), at.y}, words, height, link.accepted ? kGood : kBad);
}

// As many lines as there is room for, the last one says how many more there are.
void draw_list(Image& image, const Layout& at, const TeamPicture& team, const std::vector<TeamPicture::Link>& links) {
  const float left = 0.6f * static_cast<float>(image.width), line = 30 * at.unit, text = 13 * at.unit;
  float y = 0.14f * static_cast<float>(image.height);
  const auto in_map = std::ranges::count_if(team.robots, [](const auto& robot) { return robot.in_map; });
  draw_text(image, {left, y}, fmt::format("{} robots, {} in the map", team.robots.size(), in_map), 18 * at.unit, kInk);
  if (!team.reference.empty())
    draw_text(image, {left, y += line}, fmt::format("in the frame of {}", team.reference), text, kSoftInk);
  y += 0.6f * line;
  const auto room = static_cast<std::size_t>(std::max(1.0f, (0.94f * static_cast<float>(image.height) - y) / line));
  for (std::size_t i = 0; i < std::min(links.size(), room); ++i) {
    const TeamPicture::Link& link = links[i];
    if (i + 1 == room && links.size() > room) {
      draw_text(image, {left, y + line}, fmt::format("and {} more", links.size() - i), text, kSoftInk);
      return;
    }
    draw_link_words(image, {left, y += line}, text, team, link);
  }
}

}  // namespace

Image draw_team(const TeamPicture& team, int width_px, int height_px) {
  Image image(width_px, height_px, kSheet);
  const Layout at(image, team.robots.size());
  std::vector<TeamPicture::Link> links = team.links;
  std::erase_if(links, [&](const auto& l) { return std::max(l.a, l.b) >= team.robots.size() || l.a == l.b; });
  std::ranges::stable_sort(links, {}, [](const auto& l) { return !l.accepted; });
  for (auto link = links.rbegin(); link != links.rend(); ++link) draw_link(image, at, *link);
  for (const auto& link : links) draw_count(image, at, link);
  for (std::size_t i = 0; i < team.robots.size(); ++i) draw_robot(image, at, i, team);
  draw_list(image, at, team, links);
  return image;
}

}  // namespace onemap::render
