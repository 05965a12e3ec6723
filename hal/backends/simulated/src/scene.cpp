#include "scene.hpp"

namespace onemap::hal::simulated {

namespace {
constexpr Vec3 kX{1, 0, 0}, kY{0, 1, 0}, kZ{0, 0, 1};
}

double light_on(Vec3 normal) {
  constexpr Vec3 kLamp{0.12, 0.16, 0.98}, kWindow{0.78, -0.55, 0.3};
  const double lamp = dot(normal, kLamp), window = dot(normal, kWindow);
  return 0.76 + 0.22 * (lamp > 0 ? lamp : 0.0) + 0.2 * (window > 0 ? window : 0.0);
}

void SceneBuilder::place(double x, double y, double turns, double z) {
  place_ = {x, y, z};
  turns_ = turns;
  cos_ = cos_turns(turns);
  sin_ = sin_turns(turns);
}

Vec3 SceneBuilder::turned(Vec3 p) const { return {cos_ * p.x - sin_ * p.y, sin_ * p.x + cos_ * p.y, p.z}; }

std::size_t SceneBuilder::add_texture(Style style, double width_m, double height_m, double light) {
  const std::uint64_t key = repeated_ ? hash(*repeated_, ++repeated_surfaces_) : hash(key_, 1000 + ++surfaces_);
  scene_.textures.push_back(paint(style, key, width_m, height_m, light_ * light));
  return scene_.textures.size() - 1;
}

void SceneBuilder::add_patch(Vec3 origin, Vec3 u, Vec3 v, double size_u, double size_v, Style style, bool round) {
  const Vec3 axis_u = turned(u), axis_v = turned(v);
  const std::size_t texture = add_texture(style, size_u, size_v, light_on(cross(axis_u, axis_v)));
  scene_.patches.push_back({place_ + turned(origin), axis_u, axis_v, size_u, size_v, round, texture});
}

void SceneBuilder::room(double size_x, double size_y, double height, Style wall, Style floor, Style ceiling) {
  place(0, 0, 0);
  const double x = size_x / 2, y = size_y / 2;
  add_patch({x, -y, 0}, -1.0 * kX, kZ, size_x, height, wall);
  add_patch({-x, y, 0}, kX, kZ, size_x, height, wall);
  add_patch({x, y, 0}, -1.0 * kY, kZ, size_y, height, wall);
  add_patch({-x, -y, 0}, kY, kZ, size_y, height, wall);
  add_patch({-x, -y, 0}, kX, kY, size_x, size_y, floor);
  add_patch({-x, y, height}, kX, -1.0 * kY, size_x, size_y, ceiling);
}

void SceneBuilder::box(Vec3 foot, Vec3 size, Style style, bool back) { box(foot, size, style, style, back); }

void SceneBuilder::box(Vec3 foot, Vec3 size, Style front, Style rest, bool back) {
  const double x = size.x / 2, y = size.y / 2;
  add_patch(foot + Vec3{x, y, 0}, -1.0 * kX, kZ, size.x, size.z, front);
  add_patch(foot + Vec3{x, -y, 0}, kY, kZ, size.y, size.z, rest);
  add_patch(foot + Vec3{-x, y, 0}, -1.0 * kY, kZ, size.y, size.z, rest);
  add_patch(foot + Vec3{-x, -y, size.z}, kX, kY, size.x, size.y, rest);
  if (back) add_patch(foot + Vec3{-x, -y, 0}, kX, kZ, size.x, size.z, rest);
}

void SceneBuilder::turned_box(Vec3 foot, Vec3 size, double turns, Style style) {
  const Vec3 outer = place_;
  const double outer_turns = turns_;
  const Vec3 at = place_ + turned(foot);
  place(at.x, at.y, outer_turns + turns, at.z);
  box({}, size, style);
  place(outer.x, outer.y, outer_turns, outer.z);
}

void SceneBuilder::tube(Vec3 foot, double radius, double height, Style style, bool lid) {
  // The way round is measured on a square (see Caster): 4 quarters of pi/2 radii each.
  const std::size_t texture = add_texture(style, 6.2832 * radius, height, 1);
  scene_.curved.push_back({place_ + turned(foot), radius, height, texture});
  if (lid) add_patch(foot + Vec3{-radius, -radius, height}, kX, kY, 2 * radius, 2 * radius, style, true);
}

void SceneBuilder::ball(Vec3 centre, double radius, Style style) {
  const std::size_t texture = add_texture(style, 6.2832 * radius, 2 * radius, 1);
  scene_.curved.push_back({place_ + turned(centre), radius, 0, texture});
}

void SceneBuilder::repeat(std::optional<std::uint64_t> key) {
  repeated_ = key;
  repeated_surfaces_ = 0;
}

}  // namespace onemap::hal::simulated
