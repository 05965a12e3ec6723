#include "hal/imaging/plane_offset.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "hal/imaging/image_size.hpp"
#include "hal/lens.hpp"
#include "jackknife.hpp"
#include "small_solve.hpp"

namespace onemap::hal::imaging {

namespace {

constexpr int kCell_px = 16, kStep_px = 2;
constexpr std::size_t kLeastSamples = 48;  // of a cell's 64
constexpr double kFlat = 2, kSame = 2.5;   // deviations of the noise: within a cell, and of a neighbour from the plane
constexpr std::size_t kLeastCells = 30;    // of a plane
constexpr int kRounds = 4;
constexpr double kMost_m = 0.2;
// What takes no average: two planes that meet flatly look like one, and nothing in a room is quite flat.
constexpr double kRoom_m = 0.002;

using Fit = NormalEquations<3>;
using Coefficients = std::array<double, 3>;

double at(const Coefficients& plane, double x, double y) { return plane[0] * x + plane[1] * y + plane[2]; }

}  // namespace

struct PlaneOffset::Cell {
  Fit fit;                      // of the inverse depth, weighed by its noise
  std::vector<Sample> samples;  // empty: no plane
  double unrest = 0;            // mean square of what its own plane leaves, in deviations
};

PlaneOffset::PlaneOffset(const Intrinsics& depth, const DepthNoise& noise)
    : k_(depth), noise_(noise), columns_(depth.width / kCell_px), rows_(depth.height / kCell_px) {}

std::vector<PlaneOffset::Cell> PlaneOffset::cells_of(std::span<const std::uint16_t> depth) const {
  std::vector<Cell> cells(static_cast<std::size_t>(columns_ * rows_));
  for (int v = 0; v < rows_ * kCell_px; v += kStep_px)
    for (int u = 0; u < columns_ * kCell_px; u += kStep_px) {
      const std::uint16_t value =
          depth[static_cast<std::size_t>(v) * static_cast<std::size_t>(k_.width) + static_cast<std::size_t>(u)];
      if (value == 0) continue;
      const double z = value / k_.depth_scale, sigma = noise_.sigma_m(z) / (z * z);
      const Point2 ray = ray_of(k_, {static_cast<double>(u), static_cast<double>(v)});
      Cell& cell = cells[static_cast<std::size_t>(v / kCell_px * columns_ + u / kCell_px)];
      cell.fit.add({ray.x, ray.y, 1}, 1 / z, 1 / (sigma * sigma));
      cell.samples.push_back({static_cast<float>(ray.x), static_cast<float>(ray.y), static_cast<float>(z)});
    }
  for (Cell& cell : cells) {
    Coefficients plane{};
    const bool enough = cell.samples.size() >= kLeastSamples && cell.fit.solve(plane);
    cell.unrest = enough ? cell.fit.left(plane) / static_cast<double>(cell.samples.size()) : 1e9;
    if (cell.unrest > kFlat * kFlat) cell.samples.clear();
  }
  return cells;
}

// From the calmest cell outwards, as long as the neighbours lie in the plane of what is there already.
void PlaneOffset::add(std::span<const std::uint16_t> depth) {
  assert(depth.size() == size_of(k_).pixels());
  std::vector<Cell> cells = cells_of(depth);
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (!cells[i].samples.empty()) order.push_back(i);
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return cells[i].unrest; });
  const auto across = static_cast<std::size_t>(columns_);
  std::vector<std::size_t> queue;
  for (const std::size_t seed : order) {
    if (cells[seed].samples.empty()) continue;
    Plane plane{images_, {}};
    Fit fit;
    Coefficients now{};
    queue.assign(1, seed);
    std::size_t taken = 0;
    for (std::size_t head = 0; head < queue.size(); ++head) {
      Cell& cell = cells[queue[head]];
      const auto count = static_cast<double>(cell.samples.size());
      if (count == 0 || (head > 0 && cell.fit.left(now) > kSame * kSame * count)) continue;
      fit.add(cell.fit);
      if (!fit.solve(now)) break;
      plane.samples.insert(plane.samples.end(), cell.samples.begin(), cell.samples.end());
      cell.samples.clear();
      ++taken;
      const std::size_t x = queue[head] % across;
      if (x > 0) queue.push_back(queue[head] - 1);
      if (x + 1 < across) queue.push_back(queue[head] + 1);
      if (queue[head] >= across) queue.push_back(queue[head] - across);
      if (queue[head] + across < cells.size()) queue.push_back(queue[head] + across);
    }
    if (taken >= kLeastCells) planes_.push_back(std::move(plane));
  }
  ++images_;
}

// What a plane says of the offset that is still lacking, and how much. The bend is looked for along the plane's own
// inverse depth, not the measured one, whose noise would look like a bend.
PlaneOffset::Word PlaneOffset::word_of(const Plane& plane, double offset) const {
  Fit inverse, bend;
  Coefficients w{}, g{};
  for (const Sample& s : plane.samples) inverse.add({s.x, s.y, 1}, 1 / (s.z_m + offset));
  if (!inverse.solve(w)) return {};
  for (const Sample& s : plane.samples) bend.add({s.x, s.y, 1}, at(w, s.x, s.y) * at(w, s.x, s.y));
  if (!bend.solve(g)) return {};
  double right = 0, information = 0;
  for (const Sample& s : plane.samples) {
    const double flat = at(w, s.x, s.y), across = flat * flat - at(g, s.x, s.y);
    right += across * (1 / (s.z_m + offset) - flat);
    information += across * across;
  }
  return information > 0 ? Word{right / information, information} : Word{};
}

double PlaneOffset::without(int group, int groups) const {
  double offset = 0;
  for (int round = 0; round < kRounds; ++round) {
    double right = 0, information = 0;
    for (const Plane& plane : planes_) {
      if (group >= 0 && group_of(plane.image, images_, groups) == group) continue;
      const Word word = word_of(plane, offset);
      right += word.information * word.lacking_m;
      information += word.information;
    }
    if (!(information > 0)) return offset;
    offset = std::clamp(offset + right / information, -kMost_m, kMost_m);
  }
  return offset;
}

Estimate PlaneOffset::estimate() const {
  const int groups = std::min(images_, kGroups);
  if (groups < kLeastGroups || planes_.empty()) return {0, std::numeric_limits<double>::infinity()};
  Spread spread;
  for (int g = 0; g < groups; ++g) spread.add(without(g, groups));
  return {without(-1, groups), std::hypot(spread.sigma(), kRoom_m)};
}

}  // namespace onemap::hal::imaging
