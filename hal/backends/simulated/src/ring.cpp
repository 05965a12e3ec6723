#include "ring.hpp"

#include <cmath>

#include "furniture.hpp"
#include "walk.hpp"

namespace onemap::hal::simulated {

namespace {

constexpr double kSide = 15, kWide = 2.4, kCorridorHigh = 2.6;  // metres: of the middle's square, and of the corridor
constexpr double kOuter = (kSide + kWide) / 2, kInner = (kSide - kWide) / 2;  // from the centre to the walls
constexpr double kRingRound_s = 100;
constexpr int kRingWaypoints = 40;  // every 1.5 m of the middle

// Where something stands with its back to the wall of a side (0 south, 1 east, 2 north, 3 west), `along` metres to the
// right of its middle as seen from the centre.
void stand(SceneBuilder& b, int side, double along, double distance, bool at_outer_wall) {
  const double turns = side / 4.0, c = cos_turns(turns), s = sin_turns(turns);
  const double x = along, y = -distance;
  b.place(c * x - s * y, s * x + c * y, turns + (at_outer_wall ? 0 : .5));
}

void door(SceneBuilder& b, std::uint64_t doors, std::uint64_t signs) {
  b.repeat(doors);
  b.box({0, .03, 0}, {.95, .06, 2.05}, Style::door, Style::wood, false);
  b.repeat(signs);
  hanging(b, .75, 1.4, .3, .2, Style::poster);
  b.repeat(std::nullopt);
}

// The middle's square, its corners cut by the spline through these points.
Vec3 waypoint(std::int64_t index) {
  const double at =
      4.0 * static_cast<double>((index % kRingWaypoints + kRingWaypoints) % kRingWaypoints) / kRingWaypoints;
  const int side = static_cast<int>(at);
  const double along = kSide * (at - side - .5);
  const double turns = side / 4.0, c = cos_turns(turns), s = sin_turns(turns);
  return {c * along + s * kSide / 2, s * along - c * kSide / 2, 0};
}

// A uniform cubic B-spline, and its derivative by the waypoints' number.
struct OnRing {
  Vec3 position, heading;
};
OnRing on_ring(double rounds) {
  const double at = kRingWaypoints * rounds, start = std::floor(at), t = at - start;
  const double weights[4] = {(1 - t) * (1 - t) * (1 - t) / 6, (3 * t * t * t - 6 * t * t + 4) / 6,
                             (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6, t * t * t / 6};
  const double slopes[4] = {-(1 - t) * (1 - t) / 2, (3 * t * t - 4 * t) / 2, (-3 * t * t + 2 * t + 1) / 2, t * t / 2};
  OnRing out{};
  for (int i = 0; i < 4; ++i) {
    const Vec3 p = waypoint(static_cast<std::int64_t>(start) + i - 1);
    out.position = out.position + weights[i] * p;
    out.heading = out.heading + slopes[i] * p;
  }
  return out;
}

// The turns of a direction from east, by a polynomial whose error (a third of a degree) is smooth: the same on every
// machine.
double turns_of(Vec3 d) {
  const double x = d.x < 0 ? -d.x : d.x, y = d.y < 0 ? -d.y : d.y;
  const bool steep = y > x;
  const double q = steep ? x / y : y / x;
  const double octant = q * (.125 + .0434 * (1 - q));
  const double quadrant = steep ? .25 - octant : octant;
  const double half = d.x < 0 ? .5 - quadrant : quadrant;
  return d.y < 0 ? 1 - half : half;
}

}  // namespace

void ring(SceneBuilder& b) {
  Random& r = b.random();
  b.room(2 * kOuter, 2 * kOuter, kCorridorHigh, Style::plaster, Style::tiles, Style::ceiling);
  b.place(0, 0, 0);
  b.box({0, 0, 0}, {2 * kInner, 2 * kInner, kCorridorHigh}, Style::plaster);
  const std::uint64_t doors = r.next(), signs = r.next();
  for (int side = 0; side < 4; ++side) {
    for (int i = -3; i <= 3; ++i) {
      stand(b, side, 2.2 * i, kOuter, true);
      door(b, doors, signs);
      if (i > -3 && i < 3) {
        stand(b, side, 2.2 * i, kInner, false);
        door(b, doors, signs);
      }
    }
    for (const double along : {-5.5, -1.1, 3.3}) {
      stand(b, side, along + r.range(-.2, .2), kOuter, true);
      hanging(b, 0, 1.2, .6, .8, r.chance(.5) ? Style::poster : Style::picture);
      stand(b, side, along + 2.2 + r.range(-.2, .2), kInner, false);
      hanging(b, 0, 1.2, .6, .8, r.chance(.5) ? Style::poster : Style::picture);
    }
    stand(b, side, kOuter - .4, kOuter - .4, true);  // in the corner
    if (r.chance(.5))
      plant(b);
    else
      box_stack(b, 2);
  }
}

CameraPose pose_in_ring(int robot, int robots, std::uint64_t seed, double time_s) {
  constexpr double kDegree = 1.0 / 360;
  Random random(hash(hash(seed, 79), static_cast<std::uint64_t>(robot)));
  const double height = 1.4 + random.range(-.06, .06), aside = random.range(-.15, .15);
  const Sway x = sway(random, .03, .11, .008, .55), y = sway(random, .03, .13, .008, .6),
             z = sway(random, .04, .14, .008, .7);
  const Sway yaw = sway(random, 4 * kDegree, .13, .5 * kDegree, .5),
             nod = sway(random, 3 * kDegree, .12, .4 * kDegree, .6),
             roll = sway(random, 1.5 * kDegree, .17, .3 * kDegree, .5);
  const double start = Random(hash(seed, 80)).uniform();
  const OnRing at = on_ring(start + static_cast<double>(robot - 1) / robots + time_s / kRingRound_s);
  const double heading = turns_of(at.heading);
  const Vec3 outward{sin_turns(heading), -cos_turns(heading), 0};
  const Vec3 position{at.position.x + aside * outward.x + x.at(time_s),
                      at.position.y + aside * outward.y + y.at(time_s), height + z.at(time_s)};
  return looking(position, heading - 32 * kDegree + yaw.at(time_s), -7 * kDegree + nod.at(time_s), roll.at(time_s));
}

}  // namespace onemap::hal::simulated
