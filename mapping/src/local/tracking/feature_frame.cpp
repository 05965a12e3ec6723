#include "feature_frame.hpp"

#include <algorithm>
#include <array>
#include <cmath>

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

}  // namespace

void attach_geometry(FeatureFrame& frame, std::span<const std::uint16_t> depth, const RayTable& rays,
                     double depth_scale) {
  const std::size_t n = frame.set.size();
  frame.ray.resize(n);
  frame.point.resize(n);
  frame.landmark.assign(n, -1);
  for (std::size_t i = 0; i < n; ++i) {
    const Keypoint& k = frame.set.keypoints[i];
    frame.ray[i] = rays.at(k.x_px, k.y_px);
    const double z = depth_at(depth, rays.width(), rays.height(), k.x_px, k.y_px, depth_scale);
    frame.point[i] = {frame.ray[i].x() * z, frame.ray[i].y() * z, z};
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
