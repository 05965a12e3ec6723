#include "render/compare.hpp"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>

#include "render/drawing.hpp"
#include "render/upright.hpp"

namespace onemap::render {
namespace {

using mapping::Vector3f;
constexpr float kCell_m = 0.04f;

// Points by cells of a grid.
class Cells {
 public:
  explicit Cells(std::span<const Vector3f> points) : points_(points) {
    for (std::uint32_t i = 0; i < points.size(); ++i)
      if (points[i].allFinite()) cells_[key(cell(points[i]))].push_back(i);
  }

  // The nearest point within limit_m, or -1. Rings of cells outwards until none can hold a nearer one.
  std::int64_t nearest(const Vector3f& p, float limit_m) const {
    const Cell centre = cell(p);
    float best = limit_m * limit_m;
    std::int64_t found = -1;
    for (int ring = 0; static_cast<float>(ring - 1) * kCell_m <= std::sqrt(best); ++ring)
      visit(centre, ring, p, best, found);
    return found;
  }

 private:
  using Cell = std::array<int, 3>;
  static Cell cell(const Vector3f& p) {
    const auto index = [](float x) { return static_cast<int>(std::floor(std::clamp(x / kCell_m, -1e6f, 1e6f))); };
    return {index(p.x()), index(p.y()), index(p.z())};
  }
  static std::uint64_t key(const Cell& c) {
    const auto part = [](int i) { return static_cast<std::uint64_t>(i + (1 << 20)) & 0x1FFFFFu; };
    return (part(c[0]) << 42) | (part(c[1]) << 21) | part(c[2]);
  }
  void visit(const Cell& centre, int ring, const Vector3f& p, float& best, std::int64_t& found) const {
    for (int z = -ring; z <= ring; ++z)
      for (int y = -ring; y <= ring; ++y)
        for (int x = -ring; x <= ring; x += std::max(std::abs(y), std::abs(z)) == ring || ring == 0 ? 1 : 2 * ring)
          search({centre[0] + x, centre[1] + y, centre[2] + z}, p, best, found);
  }
  void search(const Cell& at, const Vector3f& p, float& best, std::int64_t& found) const {
    const auto here = cells_.find(key(at));
    if (here == cells_.end()) return;
    for (const std::uint32_t i : here->second) {
      const float squared = (points_[i] - p).squaredNorm();
      if (squared > best || (squared == best && found >= 0)) continue;
      best = squared;
      found = i;
    }
  }

  std::span<const Vector3f> points_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;
};

void move(std::vector<mapping::Pose>& poses, const mapping::Pose& T) {
  for (mapping::Pose& pose : poses) pose = T * pose;
}

void move(std::vector<Vector3f>& points, const mapping::Pose& T) {
  for (Vector3f& p : points) p += T.t.cast<float>();
}

const RobotPath* robot_with_keyframes(const Scene& scene, const std::string& name) {
  for (const RobotPath& robot : scene.robots)
    if (robot.name == name && !robot.keyframe_poses.empty()) return &robot;
  return nullptr;
}

// The motion that brings `there` to `here` best. Rotation: the one nearest to the sum of what each keyframe says and of
// what their places say (in metres; a metre counts as much as a radian), after Umeyama.
mapping::Pose between(const std::vector<mapping::Pose>& here, const std::vector<mapping::Pose>& there) {
  if (here.size() != there.size()) return here.front() * there.front().inverse();  // not the same ones
  const auto count = static_cast<double>(here.size());
  mapping::Vector3d mean_here = mapping::Vector3d::Zero(), mean_there = mean_here;
  for (std::size_t i = 0; i < here.size(); ++i) {
    mean_here += here[i].t / count;
    mean_there += there[i].t / count;
  }
  mapping::Matrix3d sum = mapping::Matrix3d::Zero();
  for (std::size_t i = 0; i < here.size(); ++i)
    sum += here[i].R * there[i].R.transpose() + (here[i].t - mean_here) * (there[i].t - mean_there).transpose();
  const Eigen::JacobiSVD<mapping::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double handedness = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  const mapping::Matrix3d R =
      svd.matrixU() * mapping::Vector3d(1, 1, handedness).asDiagonal() * svd.matrixV().transpose();
  return {R, mean_here - R * mean_there};
}

}  // namespace

std::vector<float> distances_m(const mapping::TriangleMesh& of, const mapping::TriangleMesh& to, float limit_m) {
  const Cells cells(to.vertices);
  const bool normals = to.normals.size() == to.vertices.size();
  std::vector<float> out;
  out.reserve(of.vertices.size());
  for (const Vector3f& p : of.vertices) {
    const std::int64_t i = p.allFinite() ? cells.nearest(p, limit_m) : -1;
    if (i < 0) {
      out.push_back(limit_m);
      continue;
    }
    const auto at = static_cast<std::size_t>(i);
    const Vector3f way = p - to.vertices[at];
    const float along = normals ? std::abs(way.dot(to.normals[at])) : 0;
    const float aside = std::sqrt(std::max(way.squaredNorm() - along * along, 0.0f));
    out.push_back(normals && aside < kCell_m ? along : way.norm());
  }
  return out;
}

DistanceSummary summary(std::vector<float> distances, float limit_m) {
  if (distances.empty()) return {};
  std::sort(distances.begin(), distances.end());
  const std::size_t n = distances.size();
  const auto beyond = distances.end() - std::lower_bound(distances.begin(), distances.end(), limit_m);
  return {distances[n / 2], distances[std::min(n - 1, n * 95 / 100)],
          static_cast<float>(beyond) / static_cast<float>(n)};
}

std::optional<mapping::Pose> motion_between(const Scene& scene, const Scene& other) {
  for (const RobotPath& robot : scene.robots) {
    const RobotPath *here = robot_with_keyframes(scene, robot.name), *there = robot_with_keyframes(other, robot.name);
    if (here != nullptr && there != nullptr) return between(here->keyframe_poses, there->keyframe_poses);
  }
  return std::nullopt;
}

Scene in_frame_of(Scene other, const Scene& scene) {
  const auto T = motion_between(scene, other);
  if (!T) return other;
  other.mesh = turned(std::move(other.mesh), T->R);
  other.points = turned(std::move(other.points), T->R);
  move(other.mesh.vertices, *T);
  move(other.points.points, *T);
  for (RobotPath& path : other.robots) {
    move(path.poses, *T);
    move(path.keyframe_poses, *T);
  }
  return other;
}

mapping::Rgb distance_color(float distance_m, float limit_m) {
  static constexpr std::array<std::array<float, 3>, 5> kStops{
      {{45, 60, 150}, {45, 150, 175}, {95, 185, 90}, {245, 205, 60}, {200, 40, 40}}};
  const float at = 4 * std::clamp(limit_m > 0 ? distance_m / limit_m : 1.0f, 0.0f, 1.0f);
  const auto low = std::min<std::size_t>(static_cast<std::size_t>(at), 3);
  mapping::Rgb out{};
  for (std::size_t c = 0; c < 3; ++c) {
    const float t = at - static_cast<float>(low);
    out[c] = static_cast<std::uint8_t>(std::lround(kStops[low][c] + t * (kStops[low + 1][c] - kStops[low][c])));
  }
  return out;
}

void draw_distance_scale(Image& image, float limit_m) {
  const auto height = static_cast<float>(image.height), text = std::max(7.0f, height * 12 / 720);
  const int tall = image.height / 2, wide = std::max(6, static_cast<int>(1.4f * text));
  const int left = image.width - static_cast<int>(9 * text), top = image.height / 4;
  fill_rectangle(image, left - wide / 2, top - 2 * wide, static_cast<int>(8.5f * text), tall + 4 * wide,
                 {255, 255, 255}, 0.72f);
  for (int y = 0; y < tall; ++y)
    fill_rectangle(image, left, top + y, wide, 1,
                   distance_color(limit_m * (1 - static_cast<float>(y) / static_cast<float>(tall)), limit_m));
  for (int i = 0; i <= 4; ++i) {
    const float part = static_cast<float>(i) / 4, y = static_cast<float>(top) + static_cast<float>(tall) * (1 - part);
    const std::string words = fmt::format("{:.3g} cm{}", 100 * limit_m * part, i == 4 ? "+" : "");
    draw_text(image, {static_cast<float>(left + wide) + 0.6f * text, y + 0.5f * text}, words, text, {35, 38, 42});
  }
}

}  // namespace onemap::render
