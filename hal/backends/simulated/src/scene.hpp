#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "arithmetic.hpp"
#include "painter.hpp"
#include "texture.hpp"

namespace onemap::hal::simulated {

// A rectangle: origin + u*axis_u + v*axis_v, 0 <= u <= size_u, 0 <= v <= size_v (metres); seen from the side of
// axis_u x axis_v. When round, only the circle that fills the square.
struct Patch {
  Vec3 origin, axis_u, axis_v;
  double size_u = 0, size_v = 0;
  bool round = false;
  std::size_t texture = 0;
};

// The outside of an upright tube (height > 0, standing on base) or of a ball (height = 0, centred on base).
struct Curved {
  Vec3 base;
  double radius = 0, height = 0;
  std::size_t texture = 0;
};

// How the team walks: on an ellipse round the middle, eyes outward (turn = 1) or fixed along a line (turn = 0).
struct Walk {
  double half_x_m = 1.2, half_y_m = 0.85, height_m = 1.35;
  double rate_turns_per_s = 17.0 / 360;  // round the ellipse
  double turn = 1;                       // turns of the eyes a turn round the ellipse
  double yaw_turns = 0;                  // of the eyes where turn = 0
  double pitch_turns = -17.0 / 360;
  double start_turns = 0, spacing_turns = 18.0 / 360;
};

struct Scene {
  std::vector<Patch> patches;
  std::vector<Curved> curved;
  std::vector<Texture> textures;
};

// Light on a surface with the given normal, about 1: a lit ceiling and a window; the same for every robot.
double light_on(Vec3 normal);

// Puts furniture together in local coordinates: x along its front, y from its back to its front, z up.
class SceneBuilder {
 public:
  explicit SceneBuilder(std::uint64_t key) : key_(key), random_(hash(key, 1)) {}

  // What is added from now on stands at (x, y, z), turned about the vertical.
  void place(double x, double y, double turns, double z = 0);
  // A room round the origin seen from inside, floor at z = 0.
  void room(double size_x, double size_y, double height, Style wall, Style floor, Style ceiling);
  // size_x * size_y * size_z on (x, y, z), the middle of its underside; no underside; backs only where asked.
  void box(Vec3 foot, Vec3 size, Style style, bool back = true);
  // A box whose front has its own style.
  void box(Vec3 foot, Vec3 size, Style front, Style rest, bool back);
  // Turned about the vertical through its own foot.
  void turned_box(Vec3 foot, Vec3 size, double turns, Style style);
  void tube(Vec3 foot, double radius, double height, Style style, bool lid);
  void ball(Vec3 centre, double radius, Style style);
  // How bright the light is that falls on what is added from now on; 1 at first.
  void light(double factor) { light_ = factor; }
  // The next surfaces are painted with this key and a count from it instead of a fresh one each: they look alike.
  void repeat(std::optional<std::uint64_t> key);

  Random& random() { return random_; }
  Scene take() { return std::move(scene_); }

 private:
  void add_patch(Vec3 origin, Vec3 u, Vec3 v, double size_u, double size_v, Style style, bool round = false);
  std::size_t add_texture(Style style, double width_m, double height_m, double light);
  Vec3 turned(Vec3 local) const;

  std::uint64_t key_, surfaces_ = 0;
  std::optional<std::uint64_t> repeated_;
  std::uint64_t repeated_surfaces_ = 0;
  Random random_;
  Vec3 place_;
  double cos_ = 1, sin_ = 0, turns_ = 0, light_ = 1;
  Scene scene_;
};

}  // namespace onemap::hal::simulated
