#include "mapping/local/ray_table.hpp"

#include <algorithm>

#include "hal/lens.hpp"

namespace onemap::mapping {

RayTable::RayTable(const hal::Intrinsics& intrinsics)
    : width_(intrinsics.width),
      height_(intrinsics.height),
      rays_(2 * static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_)) {
  float* out = rays_.data();
  for (int v = 0; v < height_; ++v) {
    for (int u = 0; u < width_; ++u) {
      const hal::Point2 ray = hal::ray_of(intrinsics, {static_cast<double>(u), static_cast<double>(v)});
      *out++ = static_cast<float>(ray.x);
      *out++ = static_cast<float>(ray.y);
    }
  }
}

Eigen::Vector2d RayTable::at(double u_px, double v_px) const {
  const double u = std::clamp(u_px, 0.0, static_cast<double>(width_ - 1));
  const double v = std::clamp(v_px, 0.0, static_cast<double>(height_ - 1));
  const int u0 = std::min(static_cast<int>(u), std::max(0, width_ - 2));
  const int v0 = std::min(static_cast<int>(v), std::max(0, height_ - 2));
  const int u1 = std::min(u0 + 1, width_ - 1), v1 = std::min(v0 + 1, height_ - 1);
  const double a = u - u0, b = v - v0;
  const auto ray = [this](int ui, int vi) {
    const float* p = row(vi) + 2 * ui;
    return Eigen::Vector2d(p[0], p[1]);
  };
  return (1 - b) * ((1 - a) * ray(u0, v0) + a * ray(u1, v0)) + b * ((1 - a) * ray(u0, v1) + a * ray(u1, v1));
}

std::size_t to_points(std::span<const std::uint16_t> depth, const RayTable& rays, double depth_scale,
                      const PointSampling& sampling, std::span<Vector3f> out) {
  const float metres = static_cast<float>(1.0 / depth_scale);
  const float farthest_m = std::min(sampling.farthest_m, kMaxDepth_m);
  std::size_t n = 0;
  for (int v = 0; v < rays.height(); v += sampling.stride) {
    const std::uint16_t* depth_row =
        depth.data() + static_cast<std::size_t>(v) * static_cast<std::size_t>(rays.width());
    const float* ray_row = rays.row(v);
    for (int u = 0; u < rays.width(); u += sampling.stride) {
      const float z = static_cast<float>(depth_row[u]) * metres;
      if (!(z >= kMinDepth_m && z <= farthest_m)) continue;
      if (n == out.size()) return n;
      out[n++] = {ray_row[2 * u] * z, ray_row[2 * u + 1] * z, z};
    }
  }
  return n;
}

}  // namespace onemap::mapping
