#include "point_spacing.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace onemap::render {

float point_spacing_m(std::span<const mapping::Vector3f> points) {
  constexpr std::size_t kProbes = 24;
  if (points.size() < 2) return 0;
  std::vector<float> nearest;
  for (std::size_t k = 0; k < std::min(kProbes, points.size()); ++k) {
    const mapping::Vector3f probe = points[k * points.size() / kProbes % points.size()];
    float best = std::numeric_limits<float>::max();
    for (const auto& p : points) {
      const float squared = (p - probe).squaredNorm();
      if (squared > 0 && squared < best) best = squared;
    }
    nearest.push_back(best);
  }
  std::sort(nearest.begin(), nearest.end());
  const float median = nearest[nearest.size() / 2];
  return median < std::numeric_limits<float>::max() ? std::sqrt(median) : 0;
}

}  // namespace onemap::render
