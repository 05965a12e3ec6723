#include "hal/imaging/edge_alignment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "hal/imaging/image_size.hpp"
#include "hal/lens.hpp"
#include "jackknife.hpp"
#include "small_solve.hpp"

namespace onemap::hal::imaging {

namespace {

constexpr int kGap_px = 10;      // without a reading, between what is in front and what is behind
constexpr double kJump = 1.08;   // of the depths
constexpr double kLevel = 1.02;  // in front, the readings beside the edge
constexpr int kEachRow = 2;
constexpr double kLeastChange = 16;  // grey levels over two pixels
constexpr double kStraight = 0.6;    // the cosine between a row or column and the edge's normal
constexpr double kReaches_px[] = {8, 8, 8, 8, 6, 6, 6, 4, 4, 4, 4, 4, 4, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3};
constexpr double kElsewhere_m = 0.005;  // from there the same should be found
constexpr std::size_t kLeastEdges = 400;
constexpr double kMostTurn = 0.005, kMostAway_m = 0.004;  // deviations: more is no calibration

using Five = std::array<double, 5>;

std::array<double, 3> moved(const ColourFromDepth& pose, double x, double y, double z) {
  const auto& r = pose.rotation;
  return {r[0] * x + r[1] * y + r[2] * z + pose.translation_m[0],
          r[3] * x + r[4] * y + r[5] * z + pose.translation_m[1],
          r[6] * x + r[7] * y + r[8] * z + pose.translation_m[2]};
}

// Turns by a small rotation vector (Rodrigues), then shifts.
ColourFromDepth changed(const ColourFromDepth& pose, const Five& by) {
  const double angle = std::sqrt(by[0] * by[0] + by[1] * by[1] + by[2] * by[2]);
  const double a = angle > 1e-9 ? std::sin(angle) / angle : 1,
               b = angle > 1e-9 ? (1 - std::cos(angle)) / (angle * angle) : 0.5;
  const double x = by[0], y = by[1], z = by[2];
  const std::array<double, 9> turn{1 - b * (y * y + z * z), b * x * y - a * z,       b * x * z + a * y,
                                   b * x * y + a * z,       1 - b * (x * x + z * z), b * y * z - a * x,
                                   b * x * z - a * y,       b * y * z + a * x,       1 - b * (x * x + y * y)};
  ColourFromDepth out = pose;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      double sum = 0;
      for (std::size_t k = 0; k < 3; ++k) sum += turn[3 * i + k] * pose.rotation[3 * k + j];
      out.rotation[3 * i + j] = sum;
    }
  out.translation_m[0] += by[3];
  out.translation_m[1] += by[4];
  return out;
}

// What changes a pose into another, nearly the same one.
Five between(const ColourFromDepth& from, const ColourFromDepth& to) {
  const auto relative = [&](std::size_t i, std::size_t j) {
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k) sum += to.rotation[3 * i + k] * from.rotation[3 * j + k];
    return sum;
  };
  return {(relative(2, 1) - relative(1, 2)) / 2, (relative(0, 2) - relative(2, 0)) / 2,
          (relative(1, 0) - relative(0, 1)) / 2, to.translation_m[0] - from.translation_m[0],
          to.translation_m[1] - from.translation_m[1]};
}

// A grey image between its pixels.
class Grey {
 public:
  Grey(const std::vector<std::uint8_t>& grey, int width, int height) : grey_(grey), width_(width), height_(height) {}
  bool has(double u, double v, double margin) const {
    return u >= margin && v >= margin && u < width_ - 1 - margin && v < height_ - 1 - margin;
  }
  double at(double u, double v) const {
    const auto x = static_cast<std::size_t>(u), y = static_cast<std::size_t>(v), w = static_cast<std::size_t>(width_);
    const double a = u - static_cast<double>(x), b = v - static_cast<double>(y);
    const std::uint8_t* p = &grey_[y * w + x];
    return (1 - b) * ((1 - a) * p[0] + a * p[1]) + b * ((1 - a) * p[w] + a * p[w + 1]);
  }

 private:
  const std::vector<std::uint8_t>& grey_;
  int width_, height_;
};

}  // namespace

// Of an edge, the residual along its normal in the colour image, and what moves it.
struct EdgeAlignment::Match {
  double off_px = 0;
  Five J{};
};

void EdgeAlignment::add(std::span<const std::uint8_t> rgb, std::span<const std::uint16_t> depth) {
  assert(rgb.size() == 3 * size_of(colour_).pixels() && depth.size() == size_of(depth_).pixels());
  View& view = views_.emplace_back();
  view.grey.resize(size_of(colour_).pixels());
  for (std::size_t i = 0; i < view.grey.size(); ++i)
    view.grey[i] = static_cast<std::uint8_t>((rgb[3 * i] + 2 * rgb[3 * i + 1] + rgb[3 * i + 2]) / 4);
  find_edges(view, depth);
}

void EdgeAlignment::find_edges(View& view, std::span<const std::uint16_t> depth) const {
  const auto value = [&](int u, int v) -> double {
    if (u < 0 || v < 0 || u >= depth_.width || v >= depth_.height) return 0;
    return depth[static_cast<std::size_t>(v) * static_cast<std::size_t>(depth_.width) + static_cast<std::size_t>(u)];
  };
  const auto look = [&](int u, int v, int du, int dv) {
    const double near = value(u, v), beside = value(u - du, v - dv), before = value(u - 2 * du, v - 2 * dv);
    if (near == 0 || beside == 0 || before == 0) return;
    if (std::max({near, beside, before}) > kLevel * std::min({near, beside, before})) return;
    for (int gap = 1; gap <= kGap_px; ++gap) {
      const double behind = value(u + gap * du, v + gap * dv);
      if (behind == 0) continue;
      if (behind < kJump * near) return;
      const Point2 ray = ray_of(depth_, {u + 0.5 * du, v + 0.5 * dv});
      view.edges.push_back({static_cast<float>(ray.x), static_cast<float>(ray.y),
                            static_cast<float>(near / depth_.depth_scale), du != 0});
      return;
    }
  };
  for (int v = 0; v < depth_.height; ++v)
    for (int u = 0; u < depth_.width; ++u) {
      if (v % kEachRow == 0) look(u, v, 1, 0), look(u, v, -1, 0);
      if (u % kEachRow == 0) look(u, v, 0, 1), look(u, v, 0, -1);
    }
}

bool EdgeAlignment::match(const View& view, const Edge& edge, const Guess& guess, double reach_px, Match& out) const {
  const double z = edge.z_m + guess.offset_m;
  const auto p = moved(guess.pose, edge.x * z, edge.y * z, z);
  if (p[2] < 0.05) return false;
  const Point2 pixel = pixel_of(colour_, {p[0] / p[2], p[1] / p[2]});
  const Grey grey(view.grey, colour_.width, colour_.height);
  if (!grey.has(pixel.x, pixel.y, reach_px + 3)) return false;
  const double du = edge.upright ? 1 : 0, dv = 1 - du;
  const auto change = [&](double s) {
    const double u = pixel.x + s * du, v = pixel.y + s * dv;
    return grey.at(u + du, v + dv) - grey.at(u - du, v - dv);
  };
  constexpr double kStep = 0.5;
  double best = 0, where = 0;
  for (double s = -reach_px; s <= reach_px; s += kStep) {
    const double here = std::abs(change(s)), nearness = 1 - 0.5 * s * s / (reach_px * reach_px);
    if (here < kLeastChange || here * nearness <= best) continue;
    if (std::abs(change(s - kStep)) > here || std::abs(change(s + kStep)) > here) continue;
    best = here * nearness;
    const double left = std::abs(change(s - kStep)), right = std::abs(change(s + kStep)),
                 bend = left + right - 2 * here;
    where = s + (bend < 0 ? kStep * std::clamp(0.5 * (left - right) / bend, -1.0, 1.0) : 0);
  }
  if (best == 0) return false;
  const double u = pixel.x + where * du, v = pixel.y + where * dv;
  const double gu = grey.at(u + 1, v) - grey.at(u - 1, v), gv = grey.at(u, v + 1) - grey.at(u, v - 1);
  const double norm = std::hypot(gu, gv), nu = gu / norm, nv = gv / norm;
  if (!(norm > 0) || std::abs(nu * du + nv * dv) < kStraight) return false;
  out.off_px = where * (nu * du + nv * dv);
  // Of the image's place by the turn and the shift; a lens's distortion changes that too little to matter.
  const double x = p[0] / p[2], y = p[1] / p[2], a = nu * colour_.fx, b = nv * colour_.fy;
  out.J = {-a * x * y - b * (1 + y * y), a * (1 + x * x) + b * x * y, -a * y + b * x, a / p[2], b / p[2]};
  return true;
}

bool EdgeAlignment::improve(Guess& guess, double reach_px, int group, int groups, Found& found) const {
  NormalEquations<5> all;
  found.edges = 0;
  Match m;
  for (std::size_t i = 0; i < views_.size(); ++i) {
    if (group >= 0 && group_of(static_cast<int>(i), static_cast<int>(views_.size()), groups) == group) continue;
    for (const Edge& edge : views_[i].edges) {
      if (!match(views_[i], edge, guess, reach_px, m)) continue;
      const double share = m.off_px / (reach_px + 1), weight = 1 - share * share;
      all.add(m.J, m.off_px, weight * weight);
      ++found.edges;
    }
  }
  Five by{};
  if (found.edges < kLeastEdges || !all.solve(by)) return false;
  found.unrest_px = std::sqrt(all.squares / all.weight);
  guess.pose = changed(guess.pose, by);
  return true;
}

Result<EdgeAlignment::Found> EdgeAlignment::estimate(const ColourFromDepth& guess, double offset_m) const {
  const int groups = std::min(static_cast<int>(views_.size()), kGroups);
  if (groups < kLeastGroups)
    return Error{"", fmt::format("{} images are too few; {} are needed", views_.size(), kLeastGroups)};
  Found found;
  Guess other{changed(guess, {0, 0, 0, kElsewhere_m, kElsewhere_m}), offset_m}, best{guess, offset_m};
  for (Guess* start : {&other, &best})
    for (const double reach : kReaches_px)
      if (!improve(*start, reach, -1, groups, found))
        return Error{"", fmt::format("{} places where both depth and colour change are too few; {} are needed",
                                     found.edges, kLeastEdges)};
  found.pose = best.pose;
  std::array<Spread, 5> spreads;
  for (int group = 0; group < groups; ++group) {
    Guess without = best;
    Found ignored;
    for (int round = 0; round < 4; ++round)
      if (!improve(without, std::end(kReaches_px)[-1], group, groups, ignored))
        return Error{"", "all of it rests on a few images; walk on"};
    const Five off = between(found.pose, without.pose);
    for (std::size_t i = 0; i < off.size(); ++i) spreads[i].add(off[i]);
  }
  const Five apart = between(best.pose, other.pose);
  for (std::size_t i = 0; i < 5; ++i) found.sigma[i] = std::hypot(spreads[i].sigma(), apart[i]);
  const double turn = std::max({found.sigma[0], found.sigma[1], found.sigma[2]}),
               away_m = std::max(found.sigma[3], found.sigma[4]);
  if (turn > kMostTurn || away_m > kMostAway_m)
    return Error{"", fmt::format("its parts disagree by {:.2f} degrees and {:.1f} mm; things near and far, with edges "
                                 "in all directions, are needed",
                                 turn * 180 / M_PI, 1000 * away_m)};
  return found;
}

}  // namespace onemap::hal::imaging
