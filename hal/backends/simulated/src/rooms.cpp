#include "rooms.hpp"

#include "furniture.hpp"
#include "house.hpp"
#include "ring.hpp"

namespace onemap::hal::simulated {

namespace {

enum class Side { south, east, north, west };

// A rectangular room's walls: stand() makes the furniture's back touch a wall, `along` metres left of its middle as
// seen from inside.
struct Walls {
  double size_x, size_y;
  void stand(SceneBuilder& b, Side side, double along) const {
    switch (side) {
      case Side::south:
        return b.place(along, -size_y / 2, 0);
      case Side::north:
        return b.place(-along, size_y / 2, .5);
      case Side::east:
        return b.place(size_x / 2, along, .25);
      case Side::west:
        return b.place(-size_x / 2, -along, .75);
    }
  }
};

void living_room(SceneBuilder& b) {
  Random& r = b.random();
  const Walls walls{5.6, 4.6};
  b.room(walls.size_x, walls.size_y, 2.6, Style::wallpaper, Style::planks, Style::ceiling);
  const auto near = [&](double x) { return x + r.range(-.12, .12); };

  walls.stand(b, Side::north, near(-1.0));
  bookshelf(b, 1.7, 2.0);
  walls.stand(b, Side::north, near(.75));
  cupboard(b, 1.0, 1.0);
  hangings(b, -.45, .6, 1.35, 2.1, Style::picture);
  walls.stand(b, Side::north, 2.2);
  plant(b);
  b.place(-2.35, 1.9, 0);
  plant(b);

  walls.stand(b, Side::east, near(0));
  sofa(b, 2.1);
  hangings(b, -1.3, 1.3, 1.0, 2.0, Style::picture);
  b.place(2.45, -1.6, 0);
  floor_lamp(b);
  b.place(2.4, 1.85, r.uniform());
  box_stack(b, 3);

  walls.stand(b, Side::west, near(0));
  sideboard(b, 2.0);
  hangings(b, -1.2, 1.2, 1.25, 2.1, Style::picture);
  b.place(-2.4, -1.75, r.uniform());
  box_stack(b, 4);

  walls.stand(b, Side::south, near(-1.0));
  hanging(b, 0, .95, 1.3, 1.2, Style::outdoors);
  for (const double x : {-.85, .85}) b.box({x, .06, .1}, {.4, .1, 2.25}, Style::fabric, false);
  walls.stand(b, Side::south, near(1.2));
  bookshelf(b, 1.1, 1.2);
  hangings(b, -.6, .7, 1.4, 2.1, Style::picture);
  b.place(near(-1.2), -1.75, r.range(-.08, .08));
  armchair(b);

  b.place(0, 0, r.range(-.04, .04));
  rug(b, 3.0, 2.2);
  b.place(near(1.0), near(.2), .25 + r.range(-.03, .03), .012);
  table(b, 1.1, .6, .46);
  b.place(near(-.9), near(-.2), r.range(-.03, .03), .012);
  table(b, .8, .8, .5);
}

void office(SceneBuilder& b) {
  Random& r = b.random();
  const Walls walls{6.0, 4.8};
  b.room(walls.size_x, walls.size_y, 2.7, Style::plaster, Style::tiles, Style::ceiling);
  for (const Side side : {Side::north, Side::south}) {
    for (const double along : {-1.9, 0., 1.9}) {
      walls.stand(b, side, along + r.range(-.1, .1));
      desk(b, 1.5);
      hangings(b, -.7, .7, 1.4, 2.2, r.chance(.5) ? Style::poster : Style::picture);
    }
  }
  for (const Side side : {Side::east, Side::west}) {
    walls.stand(b, side, r.range(-1.4, -1.2));
    cupboard(b, 1.0, 1.9);
    walls.stand(b, side, r.range(-.2, 0.));
    hanging(b, 0, .9, 1.2, 1.0, Style::poster);
    cupboard(b, 1.1, .8);
    walls.stand(b, side, r.range(1.2, 1.4));
    bookshelf(b, 1.1, 1.9);
  }
  b.place(0, 0, r.range(-.05, .05));
  rug(b, 2.6, 1.8);
  table(b, 1.4, .8, .6);
  for (const double x : {-1.7, 1.6}) {
    b.place(x, r.range(-.5, .5), r.uniform());
    armchair(b);
  }
}

void storage(SceneBuilder& b) {
  Random& r = b.random();
  const Walls walls{6.0, 5.0};
  b.room(walls.size_x, walls.size_y, 2.9, Style::concrete, Style::concrete, Style::concrete);
  for (const Side side : {Side::north, Side::south}) {
    for (const double along : {-1.7, .3}) {
      walls.stand(b, side, along + r.range(-.1, .1));
      rack(b, 1.7);
    }
    walls.stand(b, side, 1.9);
    hangings(b, -.4, .6, 1.2, 2.2, Style::poster);
  }
  for (const Side side : {Side::east, Side::west}) {
    walls.stand(b, side, r.range(-.3, .3));
    rack(b, 1.8);
    hangings(b, -2.2, -1.1, 1.1, 2.3, Style::poster);
  }
  for (int i = 0; i < 4; ++i) {
    b.place((i % 2 == 0 ? 2.45 : -2.45) + r.range(-.1, .1), (i < 2 ? 1.75 : -1.75) + r.range(-.1, .1), r.uniform());
    if (r.chance(.5))
      barrel(b);
    else
      box_stack(b, 3);
  }
  for (int i = 0; i < 5; ++i) {
    b.place(r.range(-1.6, 1.6), r.range(-1.2, 1.2), r.uniform());
    box_stack(b, 1);
  }
}

void empty_hall(SceneBuilder& b) {
  Random& r = b.random();
  const Walls walls{7.0, 6.0};
  b.room(walls.size_x, walls.size_y, 3.4, Style::plaster, Style::tiles, Style::ceiling);
  for (const Side side : {Side::south, Side::east, Side::north, Side::west}) {
    walls.stand(b, side, 0);
    hangings(b, -2.2, 2.2, .6, 2.4, r.chance(.5) ? Style::picture : Style::poster);
    for (const double along : {-2.3, 0., 2.3}) {
      walls.stand(b, side, along + r.range(-.1, .1));
      b.box({0, .15, 0}, {.3, .3, 3.4}, Style::tiles, false);
    }
  }
}

void corridor(SceneBuilder& b) {
  const Walls walls{16.0, 2.4};
  b.room(walls.size_x, walls.size_y, 2.6, Style::plaster, Style::tiles, Style::ceiling);
  const std::uint64_t doors = b.random().next(), signs = b.random().next();
  for (const Side side : {Side::south, Side::north}) {
    for (int i = -3; i <= 3; ++i) {
      walls.stand(b, side, 2.2 * i);
      b.repeat(doors);
      b.box({0, .03, 0}, {.95, .06, 2.05}, Style::door, Style::wood, false);
      b.repeat(signs);
      hanging(b, .75, 1.4, .3, .2, Style::poster);
      b.repeat(std::nullopt);
    }
  }
}

// One brightness a surface, but for a few pictures. Most views have a corner or a piece of furniture; along the west
// wall there is wall and floor and one small picture, along the south wall for a moment nothing else at all.
void blank_walls(SceneBuilder& b) {
  Random& r = b.random();
  const Walls walls{6.0, 5.2};
  b.room(walls.size_x, walls.size_y, 2.7, Style::bare_wall, Style::bare_floor, Style::bare_wall);
  const auto bare_box = [&](double along, double back, Vec3 size) { b.box({along, back, 0}, size, Style::bare_board); };

  walls.stand(b, Side::north, r.range(-.9, -.7));
  bare_box(0, .25, {1.0, .5, 1.9});
  walls.stand(b, Side::north, r.range(.8, 1.0));
  bare_box(0, .3, {1.4, .6, .8});
  hanging(b, .1, 1.3, .6, .5, Style::picture);

  walls.stand(b, Side::east, r.range(-1.0, -.8));
  bare_box(0, .4, {1.7, .8, .45});
  walls.stand(b, Side::east, r.range(.9, 1.1));
  bare_box(0, .2, {.8, .4, 1.2});
  hanging(b, -1.0, 1.4, .5, .6, Style::poster);

  walls.stand(b, Side::west, r.range(-.2, .2));
  hanging(b, 0, 1.0, .35, .3, Style::picture);

  walls.stand(b, Side::south, r.range(.9, 1.1));
  bare_box(0, .2, {.5, .4, 2.7});
  b.place(r.range(-.2, .2), r.range(-.1, .1), r.uniform());
  bare_box(0, 0, {.5, .4, .45});
  b.place(-2.5, 2.1, r.uniform());
  bare_box(0, 0, {.5, .5, .7});
}

}  // namespace

Walk walk_in(SceneName name, std::uint64_t seed) {
  Walk walk;
  walk.start_turns = Random(hash(seed, 6)).uniform();
  switch (name) {
    case SceneName::living_room:
    case SceneName::storage:
    case SceneName::house:  // has a way of its own: pose_in_house(), pose_in_ring()
    case SceneName::ring:
    case SceneName::blank_walls:
      break;
    case SceneName::office:
      walk.half_x_m = 1.3;
      break;
    case SceneName::empty_hall:
      walk.half_x_m = 1.8;
      walk.half_y_m = 1.4;
      walk.rate_turns_per_s = 12.0 / 360;
      break;
    case SceneName::corridor:  // to and fro along the middle, eyes on one wall at a slant
      walk = {6.0, .15, 1.4, .012, 0, 35.0 / 360, -6.0 / 360, .6, .03};
      break;
  }
  return walk;
}

Scene build_scene(SceneName name, std::uint64_t seed) {
  SceneBuilder b(hash(hash(seed, 5), static_cast<std::uint64_t>(name)));
  switch (name) {
    case SceneName::living_room:
      living_room(b);
      break;
    case SceneName::office:
      office(b);
      break;
    case SceneName::storage:
      storage(b);
      break;
    case SceneName::empty_hall:
      empty_hall(b);
      break;
    case SceneName::corridor:
      corridor(b);
      break;
    case SceneName::house:
      house(b);
      break;
    case SceneName::ring:
      ring(b);
      break;
    case SceneName::blank_walls:
      blank_walls(b);
      break;
  }
  return b.take();
}

}  // namespace onemap::hal::simulated
