#include "markers.hpp"

#include <algorithm>

#include "vectors.hpp"

namespace onemap::render {
namespace {

constexpr std::size_t kMostMarkers = 15;  // a robot
constexpr double kLeastSpacing_m = 0.05;
constexpr float kDepthOfSpacing = 0.5f, kLeastDepth_m = 0.03f, kMostDepth_m = 0.3f;

std::vector<std::size_t> spread_out(const std::vector<mapping::Pose>& poses, double spacing_m) {
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const bool free = std::ranges::all_of(
        chosen, [&](std::size_t other) { return (poses[other].t - poses[i].t).norm() >= spacing_m; });
    if (free) chosen.push_back(i);
  }
  return chosen;
}

}  // namespace

Markers choose_markers(const Scene& scene) {
  Markers markers;
  double spacing_m = kLeastSpacing_m;
  for (bool few = false; !few; spacing_m *= 1.2) {
    markers.keyframes.clear();
    few = true;
    for (const RobotPath& robot : scene.robots) {
      markers.keyframes.push_back(spread_out(robot.keyframe_poses, spacing_m));
      few = few && markers.keyframes.back().size() <= kMostMarkers;
    }
    markers.depth_m = std::clamp(kDepthOfSpacing * static_cast<float>(spacing_m), kLeastDepth_m, kMostDepth_m);
  }
  return markers;
}

std::array<glm::vec3, 5> pyramid(const mapping::Pose& pose, float depth_m) {
  const double d = depth_m, w = 0.62 * d, h = 0.46 * d;  // a depth camera's field of view, about 64 x 50 degrees
  const auto at = [&](double x, double y, double z) { return to_glm(pose * mapping::Vector3d(x, y, z)); };
  return {at(0, 0, 0), at(-w, -h, d), at(w, -h, d), at(w, h, d), at(-w, h, d)};
}

}  // namespace onemap::render
