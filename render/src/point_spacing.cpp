#include "point_spacing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace onemap::render {
namespace {

constexpr std::size_t kProbes = 32, kNeighbours = 3;

// Squared distance to the third-nearest other place.
float third_nearest(const mapping::Vector3f& probe, std::span<const mapping::Vector3f> points) {
  std::array<float, kNeighbours> nearest;
  nearest.fill(std::numeric_limits<float>::max());
  for (const auto& p : points) {
    float squared = (p - probe).squaredNorm();
    if (!(squared > 0) || squared >= nearest.back()) continue;
    for (float& place : nearest)
      if (squared < place) std::swap(squared, place);
  }
  return nearest.back() < std::numeric_limits<float>::max() ? nearest.back() : nearest.front();
}

}  // namespace

float point_spacing_m(std::span<const mapping::Vector3f> points) {
  if (points.size() < 2) return 0;
  std::vector<float> distances;
  for (std::size_t k = 0; k < std::min(kProbes, points.size()); ++k)
    distances.push_back(third_nearest(points[k * points.size() / kProbes % points.size()], points));
  std::sort(distances.begin(), distances.end());
  const float wide = distances[distances.size() * 9 / 10];
  return wide < std::numeric_limits<float>::max() ? std::sqrt(wide) : 0;
}

}  // namespace onemap::render
