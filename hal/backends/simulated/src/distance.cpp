#include "distance.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "hal/backends/simulated.hpp"
#include "options.hpp"
#include "rooms.hpp"

namespace onemap::hal {

namespace simulated {

namespace {

// Of one that is nearer than `least`, else something no smaller.
double distance_to(const Patch& patch, const Vec3& at, double least) {
  const Vec3 off = at - patch.origin;
  const double out = dot(off, cross(patch.axis_u, patch.axis_v));
  if (std::abs(out) >= least) return least;
  const double u = dot(off, patch.axis_u), v = dot(off, patch.axis_v);
  double du = u - std::clamp(u, 0.0, patch.size_u), dv = v - std::clamp(v, 0.0, patch.size_v);
  if (patch.round) {
    const double r = patch.size_u / 2, x = u - r, y = v - r;
    du = std::max(0.0, std::sqrt(x * x + y * y) - r);
    dv = 0;
  }
  return std::sqrt(out * out + du * du + dv * dv);
}

double distance_to(const Curved& c, const Vec3& at) {
  const Vec3 off = at - c.base;
  if (c.height <= 0) return std::abs(std::sqrt(dot(off, off)) - c.radius);
  const double side = std::sqrt(off.x * off.x + off.y * off.y) - c.radius;
  const double above = off.z - std::clamp(off.z, 0.0, c.height);
  return std::sqrt(side * side + above * above);
}

}  // namespace

double distance_to(const Scene& scene, const Vec3& at) {
  double least = 1e9;
  for (const Patch& patch : scene.patches) least = std::min(least, distance_to(patch, at, least));
  for (const Curved& curved : scene.curved) least = std::min(least, distance_to(curved, at));
  return least;
}

}  // namespace simulated

Result<std::function<double(const std::array<double, 3>&)>> simulated_surface(const CameraAddress& address) {
  const auto options = simulated::parse_options(address);
  if (!options) return options.error();
  const auto scene = std::make_shared<const simulated::Scene>(simulated::build_scene(options->scene, options->seed));
  return std::function<double(const std::array<double, 3>&)>([scene](const std::array<double, 3>& at_m) {
    return simulated::distance_to(*scene, {at_m[0], at_m[1], at_m[2]});
  });
}

}  // namespace onemap::hal
