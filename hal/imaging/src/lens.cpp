#include "hal/imaging/lens.hpp"

namespace onemap::hal::imaging {

namespace {

constexpr int kSteps = 20;

double radial(const Intrinsics& k, double r2) { return 1 + r2 * (k.k1 + r2 * (k.k2 + r2 * k.k3)); }

Point tangential(const Intrinsics& k, Point p, double r2) {
  return {2 * k.p1 * p.x * p.y + k.p2 * (r2 + 2 * p.x * p.x), k.p1 * (r2 + 2 * p.y * p.y) + 2 * k.p2 * p.x * p.y};
}

}  // namespace

bool has_distortion(const Intrinsics& k) { return k.k1 != 0 || k.k2 != 0 || k.p1 != 0 || k.p2 != 0 || k.k3 != 0; }

Point pixel_of(const Intrinsics& k, Point ray) {
  const double r2 = ray.x * ray.x + ray.y * ray.y, grown = radial(k, r2);
  const Point shift = tangential(k, ray, r2);
  return {k.fx * (ray.x * grown + shift.x) + k.cx, k.fy * (ray.y * grown + shift.y) + k.cy};
}

Point ray_of(const Intrinsics& k, Point pixel) {
  const Point distorted{(pixel.x - k.cx) / k.fx, (pixel.y - k.cy) / k.fy};
  Point ray = distorted;
  if (!has_distortion(k)) return ray;
  for (int i = 0; i < kSteps; ++i) {
    const double r2 = ray.x * ray.x + ray.y * ray.y, grown = radial(k, r2);
    const Point shift = tangential(k, ray, r2);
    ray = {(distorted.x - shift.x) / grown, (distorted.y - shift.y) / grown};
  }
  return ray;
}

}  // namespace onemap::hal::imaging
