#include "furniture.hpp"

#include <algorithm>

namespace onemap::hal::simulated {

namespace {

void legs(SceneBuilder& b, double x, double y0, double y1, double height) {
  for (const double side : {-x, x})
    for (const double y : {y0, y1}) b.box({side, y, 0}, {.06, .06, height}, Style::wood);
}

// Things of many kinds on a board from x0 to x1 at height z, the middles at y.
void things(SceneBuilder& b, double x0, double x1, double y, double z) {
  Random& r = b.random();
  double x = x0 + .08;
  while (x < x1 - .08) {
    const double at_y = y + r.range(-.08, .08);
    switch (r.below(4)) {
      case 0:
        b.tube({x, at_y, z}, r.range(.035, .06), r.range(.08, .2), Style::poster, true);
        break;
      case 1:
        b.ball({x, at_y, z + .07}, .07, Style::fabric);
        break;
      case 2:
        b.turned_box({x, at_y, z}, {r.range(.1, .18), r.range(.1, .2), r.range(.04, .2)}, r.uniform(), Style::book);
        break;
      default:
        b.turned_box({x, at_y, z}, {r.range(.1, .2), r.range(.1, .2), r.range(.06, .16)}, r.uniform(), Style::picture);
        break;
    }
    x += r.range(.24, .38);
  }
}

void books(SceneBuilder& b, double x0, double x1, double z, double room) {
  Random& r = b.random();
  double x = x0;
  while (x < x1 - .05) {
    const double wide = std::min(r.range(.035, .10), x1 - x), high = room * r.range(.6, .95), deep = r.range(.17, .26);
    if (!r.chance(.12))
      b.box({x + wide / 2, .02 + deep / 2, z}, {wide, deep, high}, Style::book, Style::plaster, false);
    x += wide;
  }
}

}  // namespace

void bookshelf(SceneBuilder& b, double width, double height) {
  constexpr double kDeep = .32, kBoard = .03;
  const int rows = static_cast<int>(height / .38);
  const double step = (height - kBoard) / rows;
  b.box({0, .01, 0}, {width, .02, height}, Style::wood, false);
  for (const double side : {-1., 1.})
    b.box({side * (width - kBoard) / 2, kDeep / 2, 0}, {kBoard, kDeep, height}, Style::wood, false);
  for (int i = 0; i <= rows; ++i)
    b.box({0, kDeep / 2, i * step}, {width - 2 * kBoard, kDeep, kBoard}, Style::wood, false);
  for (int i = 0; i < rows; ++i) {
    const double z = i * step + kBoard, split = b.random().range(-.2, .3) * width;
    books(b, -width / 2 + kBoard, split, z, step - kBoard);
    if (i % 2 == 0)
      books(b, split, width / 2 - kBoard, z, step - kBoard);
    else
      things(b, split, width / 2 - kBoard, .18, z);
  }
}

void sofa(SceneBuilder& b, double width) {
  Random& r = b.random();
  b.box({0, .48, .06}, {width, .84, .36}, Style::fabric, false);
  b.box({0, .14, .42}, {width, .22, .44}, Style::fabric, false);
  for (const double side : {-1., 1.}) b.box({side * (width / 2 - .1), .5, .42}, {.2, .8, .2}, Style::fabric, true);
  double x = -width / 2 + .45;
  while (x < width / 2 - .3) {
    b.turned_box({x + r.range(-.08, .08), .36, .42}, {.42, .14, .38}, r.range(-.04, .04), Style::carpet);
    x += .55;
  }
}

void armchair(SceneBuilder& b) {
  b.box({0, 0, .08}, {.75, .75, .34}, Style::fabric);
  b.box({0, -.3, .42}, {.75, .16, .42}, Style::fabric);
  for (const double side : {-.31, .31}) b.box({side, .05, .42}, {.13, .65, .18}, Style::fabric);
  b.turned_box({.02, -.12, .42}, {.4, .12, .34}, .02, Style::carpet);
}

void cupboard(SceneBuilder& b, double width, double height) {
  b.box({0, .22, 0}, {width, .44, height}, Style::door, Style::wood, false);
  double z = .3;
  while (z < height - .2) {
    b.box({b.random().range(-.3, .3) * width, .45, z}, {.22, .02, .16}, Style::poster, false);
    z += .45;
  }
  if (height < 1.6) things(b, -width / 2, width / 2, .22, height);
}

void sideboard(SceneBuilder& b, double width) {
  b.box({0, .22, 0}, {width, .44, .5}, Style::wood, false);
  for (int i = 0; i < 3; ++i) b.box({(i - 1) * width * .32, .45, .08}, {width * .28, .02, .36}, Style::door, false);
  b.box({-.1 * width, .14, .52}, {1.0, .06, .58}, Style::screen, Style::metal, false);
  things(b, width * .3, width / 2, .22, .5);
  things(b, -width / 2, -width * .38, .22, .5);
}

void desk(SceneBuilder& b, double width) {
  Random& r = b.random();
  b.box({0, .38, .70}, {width, .74, .04}, Style::wood);
  legs(b, width / 2 - .06, .06, .7, .70);
  b.box({-width / 2 + .3, .4, .05}, {.4, .6, .6}, Style::door, Style::metal, true);
  const double x = r.range(-.25, .25);
  b.turned_box({x, .2, .74}, {.24, .18, .02}, 0, Style::metal);
  b.turned_box({x, .16, .76}, {.05, .04, .14}, 0, Style::metal);
  b.turned_box({x, .19, .84}, {.56, .05, .36}, r.range(-.03, .03), Style::screen);
  b.turned_box({x, .48, .74}, {.44, .15, .025}, r.range(-.01, .01), Style::poster);
  b.turned_box({x + .42, .5, .74}, {.21, .3, .01}, r.range(-.1, .1), Style::poster);
  things(b, -width / 2, x - .3, .3, .74);
  things(b, x + .3, width / 2, .25, .74);
}

void rack(SceneBuilder& b, double width) {
  Random& r = b.random();
  for (const double x : {-width / 2, width / 2})
    for (const double y : {.04, .5}) b.box({x, y, 0}, {.05, .05, 2.1}, Style::metal);
  for (const double z : {.12, .72, 1.32, 1.92}) {
    b.box({0, .27, z}, {width, .5, .03}, Style::wood);
    double x = -width / 2 + .1;
    while (x < width / 2 - .3) {
      const double wide = r.range(.25, .5);
      if (r.chance(.3))
        b.tube({x + .13, .28, z + .03}, r.range(.09, .13), r.range(.2, .42), Style::metal, true);
      else
        b.turned_box({x + wide / 2, .28, z + .03}, {wide, .36, r.range(.18, .44)}, r.range(-.02, .02),
                     r.chance(.5) ? Style::cardboard : Style::fabric);
      x += wide + r.range(.03, .12);
    }
  }
}

void table(SceneBuilder& b, double width, double depth, double height) {
  b.box({0, 0, height - .04}, {width, depth, .04}, Style::wood);
  legs(b, width / 2 - .06, -depth / 2 + .06, depth / 2 - .06, height - .04);
  for (const double y : {-.25, .25}) things(b, -width / 2, width / 2, y * depth, height);
}

void floor_lamp(SceneBuilder& b) {
  b.tube({0, 0, 0}, .16, .03, Style::metal, true);
  b.tube({0, 0, .03}, .02, 1.4, Style::metal, false);
  b.tube({0, 0, 1.4}, .2, .32, Style::carpet, true);
}

void plant(SceneBuilder& b) {
  Random& r = b.random();
  b.tube({0, 0, 0}, .19, .38, Style::tiles, true);
  b.tube({0, 0, .38}, .025, .4, Style::wood, false);
  for (int i = 0; i < 7; ++i)
    b.ball({r.range(-.17, .17), r.range(-.17, .17), r.range(.7, 1.35)}, r.range(.11, .19), Style::leaves);
}

void box_stack(SceneBuilder& b, int boxes) {
  Random& r = b.random();
  double z = 0;
  for (int i = 0; i < boxes; ++i) {
    const double high = r.range(.24, .4);
    b.turned_box({r.range(-.05, .05), r.range(-.05, .05), z}, {r.range(.4, .6), r.range(.35, .5), high}, r.uniform(),
                 Style::cardboard);
    z += high;
  }
}

void barrel(SceneBuilder& b) { b.tube({0, 0, 0}, .29, b.random().range(.8, .95), Style::metal, true); }

void hanging(SceneBuilder& b, double x, double z, double width, double height, Style style) {
  b.box({x, .0125, z}, {width, .025, height}, style, Style::wood, false);
}

void hangings(SceneBuilder& b, double x0, double x1, double z0, double z1, Style style) {
  Random& r = b.random();
  double x = x0;
  while (x < x1 - .25) {
    const double wide = std::min(r.range(.35, .8), x1 - x), high = std::min(r.range(.4, .75), z1 - z0);
    hanging(b, x + wide / 2, z0 + (z1 - z0 - high) * r.uniform(), wide, high, style);
    x += wide + r.range(.12, .3);
  }
}

void rug(SceneBuilder& b, double width, double depth) { b.box({0, 0, 0}, {width, depth, .012}, Style::carpet); }

}  // namespace onemap::hal::simulated
