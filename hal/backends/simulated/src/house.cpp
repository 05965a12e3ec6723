#include "house.hpp"

#include <cmath>

#include "furniture.hpp"
#include "walk.hpp"

namespace onemap::hal::simulated {

namespace {

constexpr double kRoom = 3.5, kDeep = 4.6, kHigh = 2.6;  // metres: a room's width, the house's depth and height
constexpr double kNorth = kDeep / 2, kSouth = -kDeep / 2, kEast = 1.5 * kRoom, kWest = -1.5 * kRoom;
constexpr double kFaceSouth = .5, kFaceNorth = 0, kFaceWest = .25, kFaceEast = .75;  // turns of what stands at a wall

void half_wall(SceneBuilder& b, double x) {
  b.place(x, kSouth, 0);
  b.box({0, .6, 0}, {.14, 1.2, kHigh}, Style::white_wall, Style::white_wall, false);
}

void window(SceneBuilder& b, double x) {
  b.place(x, kSouth, kFaceNorth);
  hanging(b, 0, .95, 1.4, 1.2, Style::outdoors);
  for (const double side : {-.9, .9}) b.box({side, .06, .12}, {.32, .1, 2.2}, Style::linen, false);
}

void kitchen_unit(SceneBuilder& b, double width) {
  b.box({0, .3, .08}, {width, .6, .8}, Style::cream, Style::cream, false);
  b.box({0, .31, .88}, {width + .04, .64, .04}, Style::light_tiles, false);
  b.box({.5, .32, .92}, {.56, .5, .01}, Style::screen, false);
  b.tube({.4, .22, .93}, .1, .16, Style::metal, true);
  b.tube({.63, .4, .93}, .08, .1, Style::poster, true);
  for (const double x : {-.6, -.25, .1}) b.turned_box({x - .05, .2, .92}, {.13, .13, .22}, .03 * x, Style::book);
  b.box({0, .17, 1.45}, {width, .34, .65}, Style::cream, Style::cream, false);
}

void stool(SceneBuilder& b) {
  b.tube({0, 0, 0}, .035, .42, Style::metal, false);
  b.tube({0, 0, .42}, .18, .05, Style::fabric, true);
}

void bed(SceneBuilder& b) {  // its head in the middle of y = 0
  b.box({0, .04, 0}, {1.6, .08, .95}, Style::wood);
  b.box({0, 1.03, .1}, {1.5, 1.9, .3}, Style::wood, Style::wood, false);
  b.box({0, 1.03, .4}, {1.46, 1.86, .16}, Style::linen, false);
  b.box({0, 1.35, .56}, {1.5, 1.2, .04}, Style::fabric);
  for (const double x : {-.36, .36}) b.turned_box({x, .32, .56}, {.58, .36, .13}, .02 * x, Style::linen);
}

void living_room(SceneBuilder& b) {
  const double middle = -kRoom;
  b.place(middle - .45, kNorth, kFaceSouth);
  sideboard(b, 1.8);
  hangings(b, -.9, 1.0, 1.35, 2.1, Style::picture);
  b.place(kWest + .35, 1.9, 0);
  plant(b);
  b.place(kWest, -.1, kFaceEast);
  sofa(b, 2.0);
  hangings(b, -1.1, 1.2, 1.1, 2.0, Style::picture);
  b.place(kWest + .35, -1.85, 0);
  floor_lamp(b);
  window(b, middle - .2);
  b.place(middle - .2, kSouth, kFaceNorth);
  bookshelf(b, 1.3, .85);
  b.place(middle + 1.1, -1.55, .06);
  armchair(b);
  b.place(middle - .3, -.1, 0);
  rug(b, 2.3, 1.7);
  b.place(middle - .5, -.1, .25, .012);
  table(b, .95, .6, .42);
}

void kitchen(SceneBuilder& b) {
  b.place(0, 0, 0);
  b.box({0, 0, 0}, {kRoom - .1, kDeep - .04, .008}, Style::light_tiles);
  b.place(0, kNorth, kFaceSouth);
  kitchen_unit(b, 2.0);
  b.place(0, kSouth, kFaceNorth);
  hangings(b, -1.3, 1.4, 1.15, 2.1, Style::picture);
  b.place(0, -1.4, 0, .008);
  rug(b, 2.2, 1.5);
  table(b, 1.3, .75, .72);
  for (const double x : {-.95, .95}) {
    b.place(x, -1.4, 0, .02);
    stool(b);
  }
  for (const double x : {-.35, .4}) {
    b.place(x, -.8, 0, .02);
    stool(b);
  }
}

void bedroom(SceneBuilder& b) {
  const double middle = kRoom;
  b.place(middle + .35, kNorth, kFaceSouth);
  desk(b, 1.5);
  hangings(b, -.9, 1.0, 1.35, 2.2, Style::poster);
  b.place(kEast, 1.35, kFaceWest);
  cupboard(b, 1.2, 2.0);
  b.place(kEast, -1.35, kFaceWest);
  bed(b);
  hangings(b, -.8, .8, 1.2, 2.0, Style::picture);
  b.place(kEast, .25, kFaceWest);
  hanging(b, 0, 1.0, .6, .9, Style::picture);
  window(b, middle + .5);
  b.place(middle - 1.25, -1.7, 0);
  plant(b);
  b.place(middle, .35, 0);
  rug(b, 2.2, 1.5);
}

// Where the round leads, from the middle of the room; degrees from east.
struct Waypoint {
  double x, y, yaw;
};
constexpr int kWaypoints = 11;
constexpr double kRound_s = 18, kWalkApart = 3.15;  // seconds; metres between the middles of two rounds
constexpr Waypoint kRound[kWaypoints] = {{-1.25, -.35, 90}, {-1.05, .05, 135}, {-.75, .30, 180}, {-.35, .45, 225},
                                         {.05, .50, 270},   {.45, .40, 315},   {.85, .15, 360},  {1.1, -.15, 405},
                                         {1.25, -.40, 450}, {.45, -.55, 450},  {-.5, -.55, 450}};
// Meanwhile the eyes go from the floor's lines to the ceiling's and back.
constexpr double kNod_s = 3, kNodMiddle_deg = -13, kNod_deg = 15;

// A uniform cubic B-spline through the round, which is closed: smooth in place and gaze.
Waypoint on_round(double rounds) {
  const double at = kWaypoints * rounds, start = std::floor(at), t = at - start;
  const double weights[4] = {(1 - t) * (1 - t) * (1 - t) / 6, (3 * t * t * t - 6 * t * t + 4) / 6,
                             (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6, t * t * t / 6};
  Waypoint sum{0, 0, 0};
  for (int i = 0; i < 4; ++i) {
    const auto index = static_cast<std::int64_t>(start) + i - 1 + kWaypoints;  // never negative
    const Waypoint& p = kRound[index % kWaypoints];
    const auto round = index / kWaypoints;
    const double turns = static_cast<double>(round) - 1;
    sum.x += weights[i] * p.x;
    sum.y += weights[i] * p.y;
    sum.yaw += weights[i] * (p.yaw + 360 * turns);
  }
  return sum;
}

}  // namespace

void house(SceneBuilder& b) {
  b.light(1.35);
  b.room(3 * kRoom, kDeep, kHigh, Style::white_wall, Style::oak, Style::ceiling);
  for (const double passage : {-kRoom / 2, kRoom / 2}) {
    half_wall(b, passage);
    b.place(passage, kNorth, kFaceSouth);
    bookshelf(b, 1.25, 1.9);
  }
  living_room(b);
  kitchen(b);
  bedroom(b);
}

CameraPose pose_in_house(int robot, std::uint64_t seed, double time_s) {
  constexpr double kDegree = 1.0 / 360;
  Random random(hash(hash(seed, 78), static_cast<std::uint64_t>(robot)));
  const double height = 1.5 + random.range(-.06, .06);
  const Sway x = sway(random, .03, .11, .008, .55), y = sway(random, .03, .13, .008, .6),
             z = sway(random, .04, .14, .008, .7);
  const Sway yaw = sway(random, 2 * kDegree, .13, .5 * kDegree, .5),
             nod = sway(random, 1.5 * kDegree, .12, .4 * kDegree, .6),
             roll = sway(random, 1.5 * kDegree, .17, .3 * kDegree, .5);
  const Waypoint at = on_round(time_s / kRound_s);
  const double middle = kWalkApart * ((robot - 1) % 3 - 1);
  const double pitch = kNodMiddle_deg + kNod_deg * sin_turns(time_s / kNod_s);
  const Vec3 position{middle + at.x + x.at(time_s), at.y + y.at(time_s), height + z.at(time_s)};
  return looking(position, at.yaw * kDegree + yaw.at(time_s), pitch * kDegree + nod.at(time_s), roll.at(time_s));
}

}  // namespace onemap::hal::simulated
