#include "mapping/team/level_frame.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace onemap::mapping {
namespace {

constexpr int kStride = 8, kArm = 3;     // pixels: between facets, and from a facet's middle to its ends
constexpr int kMostBend = 3;             // of a plane, steps of inverse depth
constexpr double kFarthest_m = 5;        // noise grows with the square
constexpr float kCosFloor = 0.94f;       // 20 degrees: normals of a floor
constexpr float kCosWall = 0.17f;        // 10 degrees
constexpr float kSlice_m = 0.06f;        // of heights that are one floor
constexpr float kLeastFloor = 0.05f;     // share of all surface that faces up
constexpr float kLeastLevel = 0.01f;     // share of all surface that faces up at all
constexpr double kLeastStraight = 0.25;  // how far walls must agree about their directions, 0 to 1

// The point of a pixel in the camera's frame; z = 0: none.
Vector3d point_at(const DepthGrid& grid, int u, int v) {
  const std::size_t pixel = static_cast<std::size_t>(v) * grid.width + static_cast<std::size_t>(u);
  const double z = grid_depth_m(grid.inverse_depth[pixel]);
  const auto& k = grid.fx_fy_cx_cy;
  return {z * (u * 1024.0 - k[2]) / k[0], z * (v * 1024.0 - k[3]) / k[1], z};
}

// Whether three pixels in a row lie on one plane: along a plane inverse depth is a straight line.
bool straight(const DepthGrid& grid, std::size_t middle, std::size_t arm) {
  const int a = grid.inverse_depth[middle - arm], b = grid.inverse_depth[middle], c = grid.inverse_depth[middle + arm];
  return a > 0 && b > 0 && c > 0 && std::abs(a + c - 2 * b) <= kMostBend;
}

std::optional<Facet> facet_at(const DepthGrid& grid, int u, int v) {
  const Vector3d p = point_at(grid, u, v);
  const std::size_t pixel = static_cast<std::size_t>(v) * grid.width + static_cast<std::size_t>(u);
  if (p.z() > kFarthest_m || !straight(grid, pixel, kArm) || !straight(grid, pixel, std::size_t{kArm} * grid.width))
    return std::nullopt;
  const Vector3d along_u = point_at(grid, u + kArm, v) - point_at(grid, u - kArm, v);
  const Vector3d along_v = point_at(grid, u, v + kArm) - point_at(grid, u, v - kArm);
  Vector3d n = along_u.cross(along_v);
  const double length = n.norm();
  if (!(length > 0)) return std::nullopt;
  n /= n.dot(p) > 0 ? -length : length;
  return Facet{p.cast<float>(), n.cast<float>(), static_cast<float>(length)};
}

// The lowest height at which a floor's share of what faces up lies.
std::optional<float> floor_height(std::span<const Facet> facets, const Vector3f& up) {
  std::vector<std::pair<float, float>> heights;  // and weight
  float all = 0, level = 0;
  for (const Facet& f : facets) {
    all += f.weight;
    if (f.normal.dot(up) < kCosFloor) continue;
    level += f.weight;
    heights.emplace_back(f.point.dot(up), f.weight);
  }
  if (heights.empty() || level < kLeastLevel * all) return std::nullopt;
  std::ranges::sort(heights);
  float inside = 0, moment = 0, most = 0, at = 0;
  for (std::size_t high = 0, low = 0; high < heights.size(); ++high) {
    const auto& [height, weight] = heights[high];
    if (most > 0 && height > at + 1.5f * kSlice_m) break;  // the next floor up
    inside += weight;
    moment += weight * height;
    for (; height - heights[low].first > kSlice_m; ++low) {
      inside -= heights[low].second;
      moment -= heights[low].second * heights[low].first;
    }
    if (inside < kLeastFloor * level || inside <= most) continue;
    most = inside;
    at = moment / inside;
  }
  return most > 0 ? std::optional(at) : std::nullopt;
}

// The direction among (x, y) and its quarter turns that walls face, as seen from x: complex numbers to the fourth power
// are equal for directions that are quarter turns apart.
Eigen::Vector2d wall_direction(std::span<const Facet> facets, const Vector3d& x, const Vector3d& y,
                               const Vector3f& up) {
  const auto squared = [](const Eigen::Vector2d& c) {
    return Eigen::Vector2d(c.x() * c.x() - c.y() * c.y(), 2 * c.x() * c.y());
  };
  Eigen::Vector2d sum(0, 0);
  double all = 0;
  for (const Facet& f : facets) {
    if (std::abs(f.normal.dot(up)) > kCosWall) continue;
    const Eigen::Vector2d n(f.normal.cast<double>().dot(x), f.normal.cast<double>().dot(y));
    sum += static_cast<double>(f.weight) * squared(squared(n.normalized()));
    all += static_cast<double>(f.weight);
  }
  if (!(sum.norm() > kLeastStraight * all)) return {1, 0};
  // The principal root twice: within an eighth of a turn of x.
  const auto root = [](const Eigen::Vector2d& c) {
    const double real = std::sqrt(std::max(0.0, (1 + c.x()) / 2)),
                 imaginary = std::sqrt(std::max(0.0, (1 - c.x()) / 2));
    return Eigen::Vector2d(real, c.y() < 0 ? -imaginary : imaginary);
  };
  return root(root(sum.normalized()));
}

}  // namespace

void add_facets(const DepthGrid& grid, const Pose& T_map_keyframe, std::vector<Facet>& out) {
  if (grid.inverse_depth.empty()) return;
  for (int v = kStride / 2; v + kArm < grid.height; v += kStride)
    for (int u = kStride / 2; u + kArm < grid.width; u += kStride) {
      const auto facet = facet_at(grid, u, v);
      if (!facet) continue;
      const Vector3d point = T_map_keyframe * facet->point.cast<double>();
      out.push_back(
          {point.cast<float>(), (T_map_keyframe.R * facet->normal.cast<double>()).cast<float>(), facet->weight});
    }
}

std::optional<Pose> level_frame(std::span<const Facet> facets, const Vector3f& up) {
  const auto floor = floor_height(facets, up);
  if (!floor) return std::nullopt;
  const Vector3d z = up.cast<double>().normalized();
  Vector3d ahead = Vector3d::UnitZ() - z.z() * z;
  if (ahead.norm() < 0.05) ahead = Vector3d::UnitX() - z.x() * z;  // ahead is up or down
  ahead.normalize();
  const Vector3d left = z.cross(ahead);
  const Eigen::Vector2d walls = wall_direction(facets, ahead, left, up);
  const Vector3d x = walls.x() * ahead + walls.y() * left;
  Pose T_level_map;
  T_level_map.R.row(0) = x.transpose();
  T_level_map.R.row(1) = z.cross(x).transpose();
  T_level_map.R.row(2) = z.transpose();
  T_level_map.t = {0, 0, -static_cast<double>(*floor)};
  return T_level_map;
}

}  // namespace onemap::mapping
