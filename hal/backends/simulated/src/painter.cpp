#include "painter.hpp"

#include <algorithm>
#include <array>

#include "canvas.hpp"

namespace onemap::hal::simulated {

namespace {

using Colour = std::array<double, 3>;  // 0..255

// What a style is made of: first noise, then the style's own structure, then marks of many sizes.
struct Recipe {
  double texel_m, brightness;
  double cell_m, stretch, noise;
  double marks_per_m2, mark_min_m, mark_max_m, contrast;
  Colour base;
  double vivid;  // 0: the base colour's shades; 1: any colours
};

// Texels are smaller where a robot comes close.
Recipe recipe_of(Style style) {
  switch (style) {
    case Style::wallpaper:
      return {.004, 145, .40, 1, 34, 75, .022, .24, 100, {215, 200, 170}, .5};
    case Style::plaster:
      return {.004, 150, .45, 1, 34, 60, .020, .20, 90, {215, 210, 200}, .3};
    case Style::ceiling:
      return {.010, 180, .80, 1, 20, 10, .05, .20, 45, {225, 225, 220}, .1};
    case Style::planks:
      return {.004, 125, .06, 9, 30, 26, .010, .08, 70, {180, 130, 80}, .15};
    case Style::tiles:
      return {.004, 140, .25, 1, 32, 55, .015, .16, 90, {190, 185, 175}, .4};
    case Style::concrete:
      return {.004, 130, .40, 1, 42, 65, .018, .20, 90, {165, 165, 160}, .3};
    case Style::carpet:
      return {.003, 115, .12, 1, 20, 120, .020, .25, 105, {160, 70, 60}, .8};
    case Style::wood:
      return {.003, 130, .05, 7, 34, 40, .010, .07, 75, {165, 115, 70}, .2};
    case Style::fabric:
      return {.003, 125, .10, 1, 26, 100, .015, .12, 85, {105, 120, 150}, .7};
    case Style::picture:
      return {.0025, 120, .15, 1, 34, 160, .012, .25, 105, {140, 130, 110}, 1};
    case Style::poster:
      return {.0025, 175, .20, 1, 16, 70, .012, .20, 110, {200, 200, 190}, 1};
    case Style::book:
      return {.002, 120, .05, 1, 14, 300, .006, .03, 85, {130, 90, 80}, 1};
    case Style::cardboard:
      return {.003, 140, .12, 1, 28, 50, .014, .10, 85, {190, 150, 105}, .2};
    case Style::metal:
      return {.003, 135, .20, 3, 30, 70, .014, .12, 90, {150, 160, 170}, .6};
    case Style::leaves:
      return {.003, 70, .06, 1, 24, 700, .015, .07, 75, {70, 120, 50}, .1};
    case Style::screen:
      return {.002, 75, .20, 1, 20, 90, .014, .18, 110, {100, 120, 150}, .9};
    case Style::door:
      return {.003, 140, .16, .15, 24, 40, .012, .09, 75, {180, 140, 100}, .25};
    case Style::outdoors:
      return {.004, 170, .40, 1, 44, 60, .02, .25, 80, {150, 190, 210}, .7};
    case Style::white_wall:
      return {.004, 160, .90, 1, 12, 42, .02, .16, 58, {224, 214, 196}, .05};
    case Style::oak:
      return {.004, 150, .06, 9, 16, 16, .010, .07, 55, {186, 146, 100}, .04};
    case Style::light_tiles:
      return {.004, 160, .25, 1, 14, 34, .015, .12, 65, {196, 192, 182}, .08};
    case Style::linen:
      return {.003, 150, .10, 1, 16, 70, .015, .10, 70, {205, 210, 214}, .35};
    case Style::cream:
      return {.003, 155, .16, .15, 12, 34, .012, .09, 60, {226, 214, 190}, .12};
    case Style::bare_wall:
      return {.05, 150, 1, 1, 0, 0, .02, .1, 0, {222, 216, 204}, .02};
    case Style::bare_floor:
      return {.05, 120, 1, 1, 0, 0, .02, .1, 0, {176, 172, 166}, .02};
    case Style::bare_board:
      return {.05, 135, 1, 1, 0, 0, .02, .1, 0, {200, 196, 190}, .1};
  }
  return {};
}

Colour mix(const Colour& a, const Colour& b, double t) {
  return {a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])};
}

Colour any_colour(Random& random) {
  constexpr std::array<Colour, 10> kColours{{{190, 50, 45},
                                             {40, 90, 170},
                                             {60, 140, 70},
                                             {225, 170, 50},
                                             {120, 60, 130},
                                             {40, 140, 150},
                                             {220, 110, 50},
                                             {200, 120, 150},
                                             {110, 80, 50},
                                             {170, 180, 190}}};
  return mix(kColours[static_cast<std::size_t>(random.below(10))],
             {random.range(0, 255), random.range(0, 255), random.range(0, 255)}, 0.2);
}

// The colours of brightness 0..255: shadow, base, accent, highlight, with the light on the surface already in them.
void choose_colours(Texture& texture, Random& random, const Recipe& recipe, double light) {
  const Colour base = mix(recipe.base, any_colour(random), 0.15 + 0.6 * recipe.vivid);
  const Colour accent = mix(base, any_colour(random), 0.2 + 0.6 * recipe.vivid);
  const std::array<Colour, 4> stops{mix(base, {18, 16, 20}, 0.92), mix(base, {30, 28, 30}, 0.1),
                                    mix(accent, {200, 200, 200}, 0.15), mix(accent, {250, 248, 240}, 0.8)};
  constexpr std::array<int, 4> kAt{0, 110, 185, 256};
  for (int i = 0; i < 256; ++i) {
    const std::size_t k = i < kAt[1] ? 0 : i < kAt[2] ? 1 : 2;
    const Colour c = mix(stops[k], stops[k + 1], static_cast<double>(i - kAt[k]) / (kAt[k + 1] - kAt[k]));
    std::uint32_t packed = 0;
    for (std::size_t channel = 0; channel < 3; ++channel)
      packed |= static_cast<std::uint32_t>(std::clamp(light * c[channel], 0.0, 255.0)) << (8 * channel);
    if (light * (c[0] + c[1] + c[2]) < 3 * 14) packed |= Texture::kDark;
    texture.colours[static_cast<std::size_t>(i)] = packed;
  }
}

void paint_planks(Canvas& canvas, Random& random) {
  constexpr double kWide = 0.14;
  double v = 0;
  while (v < canvas.height_m()) {
    double u = -random.range(0, 1.2);
    while (u < canvas.width_m()) {
      const double end = u + random.range(0.6, 1.6);
      canvas.shift(u, v, end, v + kWide, random.range(-32, 32));
      canvas.fill(end - 0.004, v, end + 0.004, v + kWide, 40);
      u = end;
    }
    canvas.fill(0, v - 0.004, canvas.width_m(), v + 0.004, 45);
    v += kWide;
  }
}

void paint_tiles(Canvas& canvas, Random& random) {
  constexpr double kSide = 0.36;
  const int columns = static_cast<int>(canvas.width_m() / kSide) + 1;
  const int rows = static_cast<int>(canvas.height_m() / kSide) + 1;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i)
      canvas.shift(i * kSide, j * kSide, (i + 1) * kSide, (j + 1) * kSide, random.range(-40, 40));
  for (int j = 0; j < rows; ++j) canvas.fill(0, j * kSide - .006, canvas.width_m(), j * kSide + .006, 70);
  for (int i = 0; i < columns; ++i) canvas.fill(i * kSide - .006, 0, i * kSide + .006, canvas.height_m(), 70);
}

// A frame of bands along the edges, share of the shorter side.
void paint_border(Canvas& canvas, Random& random, double share, int bands) {
  const double w = canvas.width_m(), h = canvas.height_m(), step = share * std::min(w, h) / bands;
  for (int i = 0; i < bands; ++i) {
    const double in = i * step, brightness = random.range(30, 230);
    canvas.fill(in, in, w - in, in + step, brightness);
    canvas.fill(in, h - in - step, w - in, h - in, brightness);
    canvas.fill(in, in, in + step, h - in, brightness);
    canvas.fill(w - in - step, in, w - in, h - in, brightness);
  }
}

void paint_label(Canvas& canvas, Random& random) {
  const double w = canvas.width_m(), h = canvas.height_m();
  canvas.fill(w * .44, 0, w * .56, h, 190);  // tape
  const double u = w * random.range(.08, .45), v = h * random.range(.1, .5);
  canvas.fill(u, v, u + .45 * w, v + .38 * h, 235);
  canvas.text(random, u + .02 * w, v + .02 * h, u + .43 * w, v + .36 * h, std::max(.012, .05 * h), 35);
}

void paint_door(Canvas& canvas, Random& random) {
  const double w = canvas.width_m(), h = canvas.height_m();
  for (const double v : {.08, .55})
    for (const double u : {.12, .55}) {
      canvas.fill(u * w, v * h, (u + .33) * w, (v + .37) * h, 70);
      canvas.fill(u * w + .012, v * h + .012, (u + .33) * w - .012, (v + .37) * h - .012, random.range(130, 175));
    }
  canvas.stamp(Mark::disc, .93 * w, .48 * h, .03, .03, 0, 30, 0);
}

void paint_structure(Style style, Canvas& canvas, Random& random) {
  const double w = canvas.width_m(), h = canvas.height_m();
  switch (style) {
    case Style::planks:
    case Style::oak:
      return paint_planks(canvas, random);
    case Style::tiles:
    case Style::light_tiles:
      return paint_tiles(canvas, random);
    case Style::carpet:
      return paint_border(canvas, random, .22, 4);
    case Style::cardboard:
      return paint_label(canvas, random);
    case Style::door:
    case Style::cream:
      return paint_door(canvas, random);
    case Style::book:
      return canvas.fill(0, h * random.range(.1, .6), w, h * random.range(.62, .9), random.range(30, 230));
    case Style::poster:
      return canvas.text(random, .1 * w, .08 * h, .9 * w, .45 * h, .022, 40);
    case Style::screen:
      return canvas.text(random, .06 * w, .1 * h, .7 * w, .9 * h, .012, 220);
    case Style::outdoors:
      return canvas.shift(0, 0, w, .45 * h, -80);
    default:
      return;
  }
}

// Sizes thin out with their square, so that there is something to see from near and from afar.
void paint_marks(const Recipe& recipe, Canvas& canvas, Random& random) {
  const int count = static_cast<int>(recipe.marks_per_m2 * canvas.width_m() * canvas.height_m() + 1.5);
  const double largest = std::min(recipe.mark_max_m, 0.4 * std::min(canvas.width_m(), canvas.height_m()));
  const double smallest = std::min(recipe.mark_min_m, largest);
  for (int i = 0; i < count; ++i) {
    const double size = smallest / (1 - random.uniform() * (1 - smallest / largest));
    const auto mark = static_cast<Mark>(random.below(kMarks));
    const double u = random.range(0, canvas.width_m()), v = random.range(0, canvas.height_m());
    const double side = random.chance(0.5) ? -1 : 1;
    const double brightness = recipe.brightness + side * recipe.contrast * random.range(0.5, 1.0);
    canvas.stamp(mark, u, v, size / 2 * random.range(0.6, 1), size / 2, random.uniform(), brightness, random.next());
  }
}

// Noise, the style's own structure, marks.
void paint_all(Style style, const Recipe& recipe, Canvas& canvas, Random& random) {
  canvas.add_noise(random, recipe.cell_m, recipe.stretch, 6, recipe.noise);
  paint_structure(style, canvas, random);
  paint_marks(recipe, canvas, random);
  if (style == Style::picture || style == Style::screen) paint_border(canvas, random, .08, 1);
  canvas.add_grain(random, 5);
}

}  // namespace

Texture paint(Style style, std::uint64_t key, double width_m, double height_m, double light) {
  const Recipe recipe = recipe_of(style);
  Random random(key);
  Canvas canvas(width_m, height_m, recipe.texel_m, recipe.brightness);
  if (recipe.noise > 0) paint_all(style, recipe, canvas, random);
  Texture texture(canvas.bytes(), canvas.width(), canvas.height(), canvas.texel_m());
  choose_colours(texture, random, recipe, light);
  return texture;
}

}  // namespace onemap::hal::simulated
