#include "walk.hpp"

#include <algorithm>

namespace onemap::hal::simulated {

Sway sway(Random& random, double slow, double slow_hz, double quick, double quick_hz) {
  return {slow,
          slow_hz * random.range(0.85, 1.15),
          quick,
          quick_hz * random.range(0.85, 1.15),
          random.uniform(),
          random.uniform()};
}

CameraPose looking(Vec3 position, double yaw, double pitch, double roll) {
  const double cy = cos_turns(yaw), sy = sin_turns(yaw), cp = cos_turns(pitch), sp = sin_turns(pitch);
  const Vec3 forward{cy * cp, sy * cp, sp}, right{sy, -cy, 0}, down = cross(forward, right);
  const double cr = cos_turns(roll), sr = sin_turns(roll);
  return {cr * right + sr * down, cr * down - sr * right, forward, position};
}

CameraPose pose_on_walk(const Walk& walk, int robot, int robots, std::uint64_t seed, double time_s) {
  constexpr double kDegree = 1.0 / 360;
  Random random(hash(hash(seed, 77), static_cast<std::uint64_t>(robot)));
  const double size = random.range(0.88, 1.06), height = random.range(-0.10, 0.10),
               pitch = random.range(-3, 2) * kDegree;
  const Sway x = sway(random, .05, .11, .012, .55), y = sway(random, .05, .13, .012, .6),
             z = sway(random, .06, .14, .010, .7);
  const Sway yaw = sway(random, 5 * kDegree, .13, .7 * kDegree, .5),
             nod = sway(random, 4 * kDegree, .12, .5 * kDegree, .6);
  const Sway roll = sway(random, 2 * kDegree, .17, .4 * kDegree, .5);

  const double spacing = std::min(walk.spacing_turns, 1.0 / robots);
  const double round = walk.start_turns + spacing * (robot - 1) + walk.rate_turns_per_s * time_s;
  const Vec3 position{size * walk.half_x_m * cos_turns(round) + x.at(time_s),
                      size * walk.half_y_m * sin_turns(round) + y.at(time_s), walk.height_m + height + z.at(time_s)};
  return looking(position, walk.turn * round + walk.yaw_turns + yaw.at(time_s),
                 walk.pitch_turns + pitch + nod.at(time_s), roll.at(time_s));
}

std::array<double, 4> quaternion_xyzw(const CameraPose& pose) {
  const Vec3 a = pose.right, b = pose.down, c = pose.forward;  // columns
  const std::array<double, 4> squares{1 + a.x - b.y - c.z, 1 - a.x + b.y - c.z, 1 - a.x - b.y + c.z,
                                      1 + a.x + b.y + c.z};
  const auto largest = static_cast<std::size_t>(std::max_element(squares.begin(), squares.end()) - squares.begin());
  const double s = 0.5 / std::sqrt(squares[largest]);
  std::array<double, 4> q{};
  switch (largest) {
    case 0:
      q = {0, a.y + b.x, c.x + a.z, b.z - c.y};
      break;
    case 1:
      q = {a.y + b.x, 0, b.z + c.y, c.x - a.z};
      break;
    case 2:
      q = {c.x + a.z, b.z + c.y, 0, a.y - b.x};
      break;
    default:
      q = {b.z - c.y, c.x - a.z, a.y - b.x, 0};
      break;
  }
  q[largest] = squares[largest];
  const double sign = q[3] < 0 ? -1 : 1;
  for (double& value : q) value *= s * sign;
  return q;
}

}  // namespace onemap::hal::simulated
