#include "render/upright.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <span>

namespace onemap::render {
namespace {

using mapping::Matrix3d;
using mapping::Vector3d;
using mapping::Vector3f;

constexpr std::size_t kMaxSamples = 20000, kMaxSeeds = 150;
constexpr float kCosCone = 0.6f;         // 53 degrees: how far the cameras' mean up may be off
constexpr float kCosNear = 0.9877f;      // 9 degrees: normals of one direction
constexpr float kLeastShare = 0.02f;     // of all surface that the direction must have
constexpr float kSlice_m = 0.04f;        // of heights that belong to one plane
constexpr double kMostFlatness = 0.05;   // thickness against width below which points are a plane
constexpr double kCosTrustedFit = 0.98;  // 11 degrees

// A piece of surface.
struct Facet {
  Vector3f point, normal;
  float weight = 1;
};

bool unit(const Vector3f& n) { return std::abs(n.squaredNorm() - 1.0f) < 0.1f; }

std::vector<Facet> facets_by_normals(std::span<const Vector3f> points, std::span<const Vector3f> normals) {
  std::vector<Facet> facets;
  const std::size_t step = points.size() / kMaxSamples + 1;
  for (std::size_t i = 0; i < points.size(); i += step)
    if (points[i].allFinite() && unit(normals[i])) facets.push_back({points[i], normals[i], 1});
  return facets;
}

std::vector<Facet> facets_by_triangles(const mapping::TriangleMesh& mesh) {
  std::vector<Facet> facets;
  const std::size_t step = mesh.triangles.size() / kMaxSamples + 1;
  for (std::size_t i = 0; i < mesh.triangles.size(); i += step) {
    const auto& t = mesh.triangles[i];
    if (std::ranges::any_of(t, [&](std::uint32_t v) { return v >= mesh.vertices.size(); })) continue;
    const Vector3f &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const Vector3f normal = (b - a).cross(c - a);
    const float twice_area = normal.norm();
    if (twice_area > 0 && std::isfinite(twice_area)) facets.push_back({a, normal / twice_area, twice_area});
  }
  return facets;
}

std::vector<Facet> facets_of(const Scene& scene) {
  const auto& mesh = scene.mesh;
  if (!mesh.vertices.empty()) {
    if (mesh.normals.size() == mesh.vertices.size()) return facets_by_normals(mesh.vertices, mesh.normals);
    return facets_by_triangles(mesh);
  }
  if (scene.points.normals.size() != scene.points.points.size()) return {};
  return facets_by_normals(scene.points.points, scene.points.normals);
}

Vector3f cameras_up(const Scene& scene) {
  Vector3d sum = Vector3d::Zero();
  double count = 0;
  for (const RobotPath& robot : scene.robots)
    for (const auto& pose : robot.keyframe_poses.empty() ? robot.poses : robot.keyframe_poses) {
      sum -= pose.R.col(1);
      count += 1;
    }
  if (!(sum.norm() > 0.1 * count) || !sum.allFinite()) return {0, -1, 0};
  return sum.normalized().cast<float>();
}

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

template <class Vectors>
void turn(Vectors& vectors, const Matrix3d& R) {
  const Eigen::Matrix3f r = R.cast<float>();
  for (Vector3f& v : vectors) v = r * v;
}

}  // namespace

Vector3f up_of(const Scene& scene) {
  const Vector3f prior = cameras_up(scene);
  const std::vector<Facet> facets = facets_of(scene);
  const Vector3f common = most_common(prior, facets);
  return common == prior ? prior : fitted(common, facets);
}

Matrix3d upright_rotation(const Vector3f& up) {
  const Vector3d y = up.cast<double>().normalized();
  Vector3d z = Vector3d(0, 0, -1) + y.z() * y;
  if (z.norm() < 0.05) z = Vector3d(-1, 0, 0) + y.x() * y;  // ahead is up or down
  z.normalize();
  Matrix3d R;
  R.row(0) = y.cross(z).transpose();
  R.row(1) = y.transpose();
  R.row(2) = z.transpose();
  return R;
}

mapping::TriangleMesh turned(mapping::TriangleMesh mesh, const Matrix3d& R) {
  turn(mesh.vertices, R);
  turn(mesh.normals, R);
  return mesh;
}

mapping::ColoredCloud turned(mapping::ColoredCloud cloud, const Matrix3d& R) {
  turn(cloud.points, R);
  turn(cloud.normals, R);
  return cloud;
}

}  // namespace onemap::render
