#include "mapping/up.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace onemap::mapping {
namespace {

constexpr std::size_t kMaxSeeds = 150;
constexpr float kCosCone = 0.6f;         // 53 degrees: how far the prior may be off
constexpr float kCosNear = 0.9877f;      // 9 degrees: normals of one direction
constexpr float kLeastShare = 0.02f;     // of all surface that the direction must have
constexpr float kSlice_m = 0.04f;        // of heights that belong to one plane
constexpr double kMostFlatness = 0.05;   // thickness against width below which points are a plane
constexpr double kCosTrustedFit = 0.98;  // 11 degrees

// Surface whose normal is near +-n, and the mean of these normals turned to n's side.
struct Support {
  float weight = 0;
  Vector3f mean = Vector3f::Zero();
};
Support support_of(const Vector3f& n, std::span<const Facet> facets, float cos_near) {
  Support out;
  for (const Facet& f : facets) {
    const float along = n.dot(f.normal);
    if (std::abs(along) < cos_near) continue;
    out.weight += f.weight;
    out.mean += (along < 0 ? -f.weight : f.weight) * f.normal;
  }
  if (out.mean.norm() > 0) out.mean.normalize();
  return out;
}

// The direction that most surface near the prior has.
Vector3f most_common(const Vector3f& prior, std::span<const Facet> facets) {
  std::vector<Facet> level;
  float all = 0;
  for (Facet f : facets) {
    all += f.weight;
    const float along = prior.dot(f.normal);
    if (std::abs(along) < kCosCone) continue;
    if (along < 0) f.normal = -f.normal;
    level.push_back(f);
  }
  Vector3f best = prior;
  float best_score = kLeastShare * all;
  for (std::size_t i = 0; i < level.size(); i += level.size() / kMaxSeeds + 1) {
    const Vector3f& seed = level[i].normal;
    const float near = prior.dot(seed), score = support_of(seed, level, kCosNear).weight * near * near;
    if (score <= best_score) continue;
    best_score = score;
    best = seed;
  }
  if (best == prior) return prior;
  for (int i = 0; i < 4; ++i) best = support_of(best, level, kCosNear).mean;
  return best;
}

// The height, along n, at which most of the level surface lies.
float main_height(const Vector3f& n, std::span<const Facet> level) {
  std::vector<std::pair<float, float>> heights;
  for (const Facet& f : level) heights.emplace_back(n.dot(f.point), f.weight);
  std::sort(heights.begin(), heights.end());
  float inside = 0, most = 0, at = heights.empty() ? 0 : heights.front().first;
  std::size_t low = 0;
  for (const auto& [height, weight] : heights) {
    inside += weight;
    while (height - heights[low].first > kSlice_m) inside -= heights[low++].second;
    if (inside > most) {
      most = inside;
      at = 0.5f * (height + heights[low].first);
    }
  }
  return at;
}

// A plane through the points of the dominant level surface is straighter than the mean of their noisy normals.
Vector3f fitted(const Vector3f& n, std::span<const Facet> facets) {
  std::vector<Facet> level;
  for (const Facet& f : facets)
    if (std::abs(n.dot(f.normal)) >= kCosNear) level.push_back(f);
  const float height = main_height(n, level);
  Vector3d mean = Vector3d::Zero();
  Matrix3d spread = Matrix3d::Zero();
  double count = 0;
  for (const Facet& f : level) {
    if (std::abs(n.dot(f.point) - height) > 1.5f * kSlice_m) continue;
    const Vector3d p = f.point.cast<double>();
    mean += p;
    spread += p * p.transpose();
    count += 1;
  }
  if (count < 30) return n;
  mean /= count;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(spread / count - mean * mean.transpose());
  const Vector3d normal = solver.eigenvectors().col(0);
  const Vector3d& widths = solver.eigenvalues();
  const double along = normal.dot(n.cast<double>());
  if (!(std::abs(along) > kCosTrustedFit) || widths[0] > kMostFlatness * kMostFlatness * widths[1]) return n;
  return (along < 0 ? -normal : normal).cast<float>().normalized();
}

}  // namespace

Vector3f up_of(std::span<const Facet> facets, const Vector3f& prior) {
  const Vector3f common = most_common(prior, facets);
  return common == prior ? prior : fitted(common, facets);
}

}  // namespace onemap::mapping
