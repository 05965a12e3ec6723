#include "feature_frame.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "hal/lens.hpp"

namespace onemap::mapping {

namespace {

// The median of the valid readings in the 3x3 neighbourhood, if they agree: a feature on a depth edge has no one depth.
double depth_at(std::span<const std::uint16_t> depth, int width, int height, double u, double v, double scale) {
  const int x = std::clamp(static_cast<int>(std::lround(u)), 1, width - 2),
            y = std::clamp(static_cast<int>(std::lround(v)), 1, height - 2);
  std::array<std::uint16_t, 9> near{};
  std::size_t n = 0;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      const auto value =
          depth[static_cast<std::size_t>(y + dy) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x + dx)];
      if (value == 0) continue;
      std::size_t at = n++;  // insertion sort of at most nine values
      for (; at > 0 && near[at - 1] > value; --at) near[at] = near[at - 1];
      near[at] = value;
    }
  if (n < 4) return 0;
  const double median = near[n / 2] / scale;
  const double spread = (near[n - 1] - near[0]) / scale;
  if (spread > 0.03 * median + 0.01 * median * median) return 0;
  return median >= kMinDepth_m && median <= kMaxDepth_m ? median : 0;
}

// Of a feature that was seen there, in a depth image that was measured before or after: the surface that is there now
// is looked up where it was then.
double depth_then(std::span<const std::uint16_t> depth, const RayTable& rays, const hal::Intrinsics& k,
                  const Vector3d& point, const Pose& T_colour_depth) {
  const Vector3d then = T_colour_depth.inverse() * point;
  if (!(then.z() >= static_cast<double>(kMinDepth_m))) return 0;
  const hal::Point2 px = hal::pixel_of(k, {then.x() / then.z(), then.y() / then.z()});
  if (!(px.x >= 0 && px.y >= 0 && px.x <= k.width - 1 && px.y <= k.height - 1)) return 0;
  const double z = depth_at(depth, k.width, k.height, px.x, px.y, k.depth_scale);
  const Eigen::Vector2d ray = rays.at(px.x, px.y);
  return z > 0 ? (T_colour_depth * Vector3d(ray.x() * z, ray.y() * z, z)).z() : 0;
}

}  // namespace

void attach_geometry(FeatureFrame& frame, std::span<const std::uint16_t> depth, const RayTable& rays,
                     const hal::Intrinsics& intrinsics, const std::optional<Pose>& T_colour_depth) {
  const std::size_t n = frame.set.size();
  frame.ray.resize(n);
  frame.point.resize(n);
  frame.landmark.assign(n, -1);
  for (std::size_t i = 0; i < n; ++i) {
    const Keypoint& k = frame.set.keypoints[i];
    frame.ray[i] = rays.at(k.x_px, k.y_px);
    const auto on_ray = [&](double z) { return Vector3d(frame.ray[i].x() * z, frame.ray[i].y() * z, z); };
    double z = depth_at(depth, rays.width(), rays.height(), k.x_px, k.y_px, intrinsics.depth_scale);
    const double then = z > 0 && T_colour_depth ? depth_then(depth, rays, intrinsics, on_ray(z), *T_colour_depth) : 0;
    if (then > 0) z = then;
    frame.point[i] = on_ray(z);
  }
}

void copy_features(const FeatureFrame& from, FeatureFrame& to) {
  to.set.kind = from.set.kind;
  to.set.keypoints.assign(from.set.keypoints.begin(), from.set.keypoints.end());
  to.set.descriptors.assign(from.set.descriptors.begin(), from.set.descriptors.end());
  to.ray.assign(from.ray.begin(), from.ray.end());
  to.point.assign(from.point.begin(), from.point.end());
  to.landmark.assign(from.landmark.begin(), from.landmark.end());
}

}  // namespace onemap::mapping
