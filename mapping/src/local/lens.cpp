#include "mapping/local/lens.hpp"

#include <cmath>

namespace onemap::mapping {

Eigen::Vector2d distorted_pixel(const hal::Intrinsics& k, const Eigen::Vector2d& ray) {
  const double x = ray.x(), y = ray.y(), r2 = x * x + y * y;
  const double radial = 1 + r2 * (k.k1 + r2 * (k.k2 + r2 * k.k3));
  const double xd = x * radial + 2 * k.p1 * x * y + k.p2 * (r2 + 2 * x * x);
  const double yd = y * radial + k.p1 * (r2 + 2 * y * y) + 2 * k.p2 * x * y;
  return {k.fx * xd + k.cx, k.fy * yd + k.cy};
}

Eigen::Vector2d undistorted_ray(const hal::Intrinsics& k, double u_px, double v_px) {
  const double xd = (u_px - k.cx) / k.fx, yd = (v_px - k.cy) / k.fy;
  double x = xd, y = yd;
  for (int i = 0; i < 100; ++i) {
    const double r2 = x * x + y * y;
    const double radial = 1 + r2 * (k.k1 + r2 * (k.k2 + r2 * k.k3));
    const double x_new = (xd - 2 * k.p1 * x * y - k.p2 * (r2 + 2 * x * x)) / radial;
    const double y_new = (yd - k.p1 * (r2 + 2 * y * y) - 2 * k.p2 * x * y) / radial;
    const double step = std::abs(x_new - x) + std::abs(y_new - y);
    x = x_new;
    y = y_new;
    if (step < 1e-12) break;
  }
  return {x, y};
}

bool inverts(const hal::Intrinsics& k, double u_px, double v_px) {
  constexpr double kTangentOf85Degrees = 11.43;
  const Eigen::Vector2d ray = undistorted_ray(k, u_px, v_px);
  if (!(ray.squaredNorm() <= kTangentOf85Degrees * kTangentOf85Degrees)) return false;
  return (distorted_pixel(k, ray) - Eigen::Vector2d(u_px, v_px)).squaredNorm() <= 1;
}

}  // namespace onemap::mapping
