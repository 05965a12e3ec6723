#include "render/follow.hpp"

#include <algorithm>
#include <limits>

namespace onemap::render {
namespace {

using mapping::Pose;

// For each keyframe the place of the way that is nearest to it, none before that of the keyframe before.
std::vector<std::size_t> places(const RobotPath& robot, const std::vector<Pose>& way) {
  std::vector<std::size_t> at;
  std::size_t from = 0;
  for (const Pose& keyframe : robot.keyframe_poses) {
    double best = std::numeric_limits<double>::max();
    std::size_t found = from;
    for (std::size_t i = from; i < way.size(); ++i) {
      const double distance = (way[i].t - keyframe.t).norm();
      if (distance < best) {
        best = distance;
        found = i;
      }
      if (best < 1e-4 && distance > best) break;  // a keyframe is a place of the way: further on is a later visit
    }
    at.push_back(found);
    from = found;
  }
  return at;
}

mapping::Matrix3d between(const mapping::Matrix3d& a, const mapping::Matrix3d& b, double t) {
  const auto p = mapping::to_quaternion_wxyz(a), q = mapping::to_quaternion_wxyz(b);
  double dot = 0;
  for (std::size_t i = 0; i < 4; ++i) dot += p[i] * q[i];
  std::array<double, 4> mixed{};
  for (std::size_t i = 0; i < 4; ++i) mixed[i] = (1 - t) * p[i] + t * (dot < 0 ? -q[i] : q[i]);
  return mapping::from_quaternion_wxyz(mixed);
}

}  // namespace

std::vector<Pose> followed(const RobotPath& robot, std::size_t every) {
  if (robot.keyframe_poses.empty()) return {};
  const std::vector<Pose>& way = robot.poses.empty() ? robot.keyframe_poses : robot.poses;
  const std::vector<std::size_t> at = places(robot, way);
  std::vector<Pose> out;
  std::size_t next = 0;  // the first keyframe beyond the place
  for (std::size_t i = 0; i < way.size(); i += std::max<std::size_t>(every, 1)) {
    while (next < at.size() && at[next] <= i) ++next;
    const std::size_t before = next > 0 ? next - 1 : 0, after = std::min(next, at.size() - 1);
    const double length = static_cast<double>(at[after]) - static_cast<double>(at[before]);
    const double t =
        length > 0 ? std::clamp((static_cast<double>(i) - static_cast<double>(at[before])) / length, 0.0, 1.0) : 0;
    out.push_back({between(robot.keyframe_poses[before].R, robot.keyframe_poses[after].R, t), way[i].t});
  }
  return out;
}

}  // namespace onemap::render
