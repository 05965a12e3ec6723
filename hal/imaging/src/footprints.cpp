#include "footprints.hpp"

#include <algorithm>

#include "hal/base/twin.hpp"
#include "hal/lens.hpp"

namespace onemap::hal::imaging::footprints {

namespace {

float widest_ray(const Intrinsics& k) {
  double widest = 0;
  for (const double u : {-0.5, k.width - 0.5})
    for (const double v : {-0.5, k.height - 0.5}) {
      const Point2 ray = ray_of(k, {u, v});
      widest = std::max(widest, ray.x * ray.x + ray.y * ray.y);
    }
  return static_cast<float>(1.1 * widest);
}

// Where a ray (x, y, 1) is imaged, and whether the lens says so: 1 or 0.
template <bool distorted>
ONEMAP_TWIN_BODY float image(const ColourLens& k, float x, float y, float& u, float& v) {
  if constexpr (distorted) {
    const float r2 = x * x + y * y, grown = 1 + r2 * (k.k1 + r2 * (k.k2 + r2 * k.k3));
    u = k.fx * (x * grown + 2 * k.p1 * x * y + k.p2 * (r2 + 2 * x * x)) + k.cx;
    v = k.fy * (y * grown + k.p1 * (r2 + 2 * y * y) + 2 * k.p2 * x * y) + k.cy;
    return r2 <= k.widest ? 1.0f : 0.0f;
  } else {
    u = k.fx * x + k.cx;
    v = k.fy * y + k.cy;
    return 1.0f;
  }
}

// No branch and no call in the loop, so that the compiler makes vectors of it.
template <bool distorted>
ONEMAP_TWIN_BODY void find_with(const Rig& rig, const Row& row, Covered& out) {
  std::int32_t* __restrict first = out.first.data();
  std::uint16_t* __restrict size = out.size.data(), * __restrict less_1 = out.less_1.data();
  const ColourLens lens = rig.lens;
  // Not the constants themselves: the compiler would know more of them, and take branches for it.
  const float nearest = rig.nearest_m, too_far = rig.too_far;
  const float tx = rig.t_m[0], ty = rig.t_m[1], tz = rig.t_m[2];
  const float metres = rig.metres, offset = rig.offset_m, scale = rig.scale;
  const float half_finer_u = 0.5f * rig.finer_u, half_finer_v = 0.5f * rig.finer_v;
  const auto width = static_cast<float>(rig.width), height = static_cast<float>(rig.height);
  const std::int32_t columns = rig.width, least = rig.least;
  const std::size_t n = row.depth.size();
  const std::uint16_t* __restrict depth = row.depth.data();
  const float* __restrict ray_x = row.ray_x, * __restrict ray_y = row.ray_y, * __restrict ray_z = row.ray_z;
  std::int32_t readings = 0, seen = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const float z_m = static_cast<float>(depth[i]) * metres + offset;
    const float x = ray_x[i] * z_m + tx, y = ray_y[i] * z_m + ty, z = ray_z[i] * z_m + tz;
    const float inverse = 1 / (z > nearest ? z : nearest);
    float u, v;
    const float known = image<distorted>(lens, x * inverse, y * inverse, u, v);
    std::int32_t u0, u1, v0, v1;
    centres_around(u, half_finer_u * (z_m * inverse) + kMargin_px, width, u0, u1);
    centres_around(v, half_finer_v * (z_m * inverse) + kMargin_px, height, v0, v1);
    const auto value = static_cast<std::int32_t>(std::min(std::max(0.0f, known * (z * scale + 0.5f)), too_far));
    const std::int32_t wide = u1 - u0, high = v1 - v0;
    // Negative when one of them is.
    const std::int32_t fits = (static_cast<std::int32_t>(depth[i]) - 1) | (wide - 1) | (high - 1) |
                              (kWidest_px - wide) | (kWidest_px - high) | (value - least) | (65535 - value);
    const std::int32_t nowhere = fits >> 31;  // all bits, or none
    first[i] = (v0 * columns + u0) | nowhere;
    size[i] = static_cast<std::uint16_t>(wide | high << 8);
    less_1[i] = static_cast<std::uint16_t>(value - 1);
    readings += depth[i] != 0 ? 1 : 0;
    seen += 1 + nowhere;
  }
  out.readings = readings;
  out.seen = seen;
}

ONEMAP_TWIN_BODY void find_body(const Rig& rig, const Row& row, Covered& out) {
  if (rig.lens.distorted)
    find_with<true>(rig, row, out);
  else
    find_with<false>(rig, row, out);
}

float as_float(double value) { return static_cast<float>(value); }

}  // namespace

ColourLens::ColourLens(const Intrinsics& k)
    : distorted(has_distortion(k)),
      fx(as_float(k.fx)),
      fy(as_float(k.fy)),
      cx(as_float(k.cx)),
      cy(as_float(k.cy)),
      k1(as_float(k.k1)),
      k2(as_float(k.k2)),
      p1(as_float(k.p1)),
      p2(as_float(k.p2)),
      k3(as_float(k.k3)),
      widest(widest_ray(k)) {}

ONEMAP_TWIN(find, (const Rig& rig, const Row& row, Covered& out), (rig, row, out))

}  // namespace onemap::hal::imaging::footprints
