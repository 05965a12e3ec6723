#include "hal/lens.hpp"

#include <cmath>

namespace onemap::hal {

namespace {
constexpr int kMostSteps = 100;
constexpr double kSmallStep = 1e-12;

double radial(const Intrinsics& k, double r2) { return 1 + r2 * (k.k1 + r2 * (k.k2 + r2 * k.k3)); }
}  // namespace

Point2 pixel_of(const Intrinsics& k, Point2 ray) {
  const double x = ray.x, y = ray.y, r2 = x * x + y * y, grown = radial(k, r2);
  const double xd = x * grown + 2 * k.p1 * x * y + k.p2 * (r2 + 2 * x * x);
  const double yd = y * grown + k.p1 * (r2 + 2 * y * y) + 2 * k.p2 * x * y;
  return {k.fx * xd + k.cx, k.fy * yd + k.cy};
}

Point2 ray_of(const Intrinsics& k, Point2 pixel) {
  const double xd = (pixel.x - k.cx) / k.fx, yd = (pixel.y - k.cy) / k.fy;
  double x = xd, y = yd;
  for (int i = 0; i < kMostSteps; ++i) {
    const double r2 = x * x + y * y, grown = radial(k, r2);
    const double x_new = (xd - 2 * k.p1 * x * y - k.p2 * (r2 + 2 * x * x)) / grown;
    const double y_new = (yd - k.p1 * (r2 + 2 * y * y) - 2 * k.p2 * x * y) / grown;
    const double step = std::abs(x_new - x) + std::abs(y_new - y);
    x = x_new;
    y = y_new;
    if (step < kSmallStep) break;
  }
  return {x, y};
}

bool has_ray(const Intrinsics& k, Point2 pixel) {
  constexpr double kTangentOf85Degrees = 11.43;
  const Point2 ray = ray_of(k, pixel);
  if (!(ray.x * ray.x + ray.y * ray.y <= kTangentOf85Degrees * kTangentOf85Degrees)) return false;
  const Point2 back = pixel_of(k, ray);
  const double du = back.x - pixel.x, dv = back.y - pixel.y;
  return du * du + dv * dv <= 1;
}

bool has_distortion(const Intrinsics& k) { return k.k1 != 0 || k.k2 != 0 || k.p1 != 0 || k.p2 != 0 || k.k3 != 0; }

}  // namespace onemap::hal
