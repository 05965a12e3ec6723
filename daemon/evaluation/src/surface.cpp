#include <algorithm>
#include <cassert>
#include <cmath>

#include "evaluation/evaluation.hpp"

namespace onemap::evaluation {

SurfaceEvaluation evaluate_surface(std::span<const Eigen::Vector3f> points, const Eigen::Isometry3d& T_truth_estimate,
                                   const std::function<double(const std::array<double, 3>&)>& distance_m) {
  assert(!points.empty());
  std::vector<double> distances;
  distances.reserve(points.size());
  double squares = 0;
  for (const Eigen::Vector3f& point : points) {
    const Eigen::Vector3d p = T_truth_estimate * point.cast<double>();
    distances.push_back(distance_m({p.x(), p.y(), p.z()}));
    squares += distances.back() * distances.back();
  }
  std::sort(distances.begin(), distances.end());
  const std::size_t count = distances.size();
  const auto off = distances.end() - std::upper_bound(distances.begin(), distances.end(), kOff_m);
  SurfaceEvaluation out;
  out.points = count;
  out.rms = std::sqrt(squares / static_cast<double>(count));
  out.median = distances[count / 2];
  out.p95 = distances[count * 95 / 100];
  out.off = static_cast<double>(off) / static_cast<double>(count);
  return out;
}

}  // namespace onemap::evaluation
