#include "render/upright.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "mapping/up.hpp"

namespace onemap::render {
namespace {

using mapping::Facet;
using mapping::Matrix3d;
using mapping::Vector3d;
using mapping::Vector3f;

constexpr std::size_t kMaxSamples = 20000;

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

template <class Vectors>
void turn(Vectors& vectors, const Matrix3d& R) {
  const Eigen::Matrix3f r = R.cast<float>();
  for (Vector3f& v : vectors) v = r * v;
}

}  // namespace

Vector3f up_of(const Scene& scene) {
  return scene.up ? *scene.up : mapping::up_of(facets_of(scene), cameras_up(scene));
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
