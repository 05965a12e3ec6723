#include "hal/imaging/register_depth.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "footprints.hpp"
#include "hal/base/twin.hpp"
#include "hal/imaging/image_size.hpp"
#include "hal/lens.hpp"
#include "nearest.hpp"

namespace onemap::hal::imaging {

namespace {

using footprints::Covered;
using footprints::Rig;

constexpr float kNearest_m = 0.01f;
constexpr float kMostTogether = 1.1f;  // colour pixels of a depth pixel: neighbours of finer images lie apart

float as_float(double value) { return static_cast<float>(value); }

Rig rig_of(const Intrinsics& depth, const Intrinsics& colour, const ColourFromDepth& pose, double offset_m) {
  const auto scale = as_float(colour.depth_scale);
  const auto& t = pose.translation_m;
  return {.lens = footprints::ColourLens(colour),
          .t_m = {as_float(t[0]), as_float(t[1]), as_float(t[2])},
          .metres = as_float(1 / depth.depth_scale),
          .offset_m = as_float(offset_m),
          .scale = scale,
          .finer_u = as_float(colour.fx / depth.fx),
          .finer_v = as_float(colour.fy / depth.fy),
          .nearest_m = kNearest_m,
          .too_far = 65536,
          .least = std::max(1, static_cast<int>(std::lround(kNearest_m * scale)) + 1),
          .width = colour.width,
          .height = colour.height};
}

// Whether the colour image sees nothing along this ray, however far the reading. Between the nearest depth that counts
// and the farthest value there is, the row v that it falls on goes one way only (a ratio of two lines), and so does the
// half of what it covers: the ends say all.
bool is_beside(const Rig& rig, double ray_y, double ray_z) {
  constexpr double kSlack_px = 2;  // of single precision
  if (rig.lens.distorted || !(ray_z > 0.1)) return false;
  const double fy = rig.lens.fy, cy = rig.lens.cy, ty = rig.t_m[1], tz = rig.t_m[2];
  const double farthest = 65535.0 * rig.metres + rig.offset_m, nearest = (0.5 * rig.nearest_m - tz) / ray_z;
  double lowest = rig.height, highest = 0, half = 0;
  for (const double z_m : {nearest, std::max(nearest, farthest)}) {
    const double z = ray_z * z_m + tz, v = fy * (ray_y * z_m + ty) / z + cy;
    lowest = z_m == nearest ? v : std::min(lowest, v);
    highest = z_m == nearest ? v : std::max(highest, v);
    half = std::max(half, 0.5 * rig.finer_v * z_m / z);
  }
  return highest + half + kSlack_px < 0 || lowest - half - kSlack_px > rig.height;
}

}  // namespace

struct DepthRegistration::Parts {
  Parts(const Intrinsics& depth_lens, const Intrinsics& colour_lens, const ColourFromDepth& pose, double offset_m)
      : depth(size_of(depth_lens)),
        colour(size_of(colour_lens)),
        rig(rig_of(depth_lens, colour_lens, pose, offset_m)),
        covered(static_cast<std::size_t>(depth.width)) {}
  const ImageSize depth, colour;
  const Rig rig;
  std::vector<bool> blind;                 // of each row: colour sees nothing of it
  std::vector<float> ray_x, ray_y, ray_z;  // a pixel's ray, turned into the colour camera's frame
  Covered covered;
  const bool simd = simd_available();
  const bool together = simd && rig.finer_u < kMostTogether;
};

DepthRegistration::DepthRegistration(const Intrinsics& depth, const Intrinsics& colour, const ColourFromDepth& pose,
                                     double offset_m)
    : parts_(std::make_unique<Parts>(depth, colour, pose, offset_m)) {
  const auto& r = pose.rotation;
  for (std::vector<float>* rays : {&parts_->ray_x, &parts_->ray_y, &parts_->ray_z})
    rays->reserve(parts_->depth.pixels());
  for (int v = 0; v < depth.height; ++v) {
    bool blind = true;
    for (int u = 0; u < depth.width; ++u) {
      const Point2 ray = ray_of(depth, {static_cast<double>(u), static_cast<double>(v)});
      parts_->ray_x.push_back(as_float(r[0] * ray.x + r[1] * ray.y + r[2]));
      parts_->ray_y.push_back(as_float(r[3] * ray.x + r[4] * ray.y + r[5]));
      parts_->ray_z.push_back(as_float(r[6] * ray.x + r[7] * ray.y + r[8]));
      blind = blind && is_beside(parts_->rig, parts_->ray_y.back(), parts_->ray_z.back());
    }
    parts_->blind.push_back(blind);
  }
}

DepthRegistration::~DepthRegistration() = default;

DepthRegistration::Counts DepthRegistration::apply(std::span<const std::uint16_t> depth,
                                                   std::span<std::uint16_t> registered) {
  Parts& p = *parts_;
  assert(depth.size() == p.depth.pixels() && registered.size() == p.colour.pixels());
  const auto width = static_cast<std::size_t>(p.depth.width), columns = static_cast<std::size_t>(p.colour.width);
  Counts counts;
  std::fill(registered.begin(), registered.end(), nearest::kNothing);
  for (std::size_t at = 0; at < depth.size(); at += width) {
    if (p.blind[at / width]) {
      const auto readings = width - static_cast<std::size_t>(std::ranges::count(depth.subspan(at, width), 0));
      counts.readings += readings;
      counts.outside += readings;
      continue;
    }
    const footprints::Row row{depth.subspan(at, width), &p.ray_x[at], &p.ray_y[at], &p.ray_z[at]};
    (p.simd ? footprints::find_simd : footprints::find_plain)(p.rig, row, p.covered);
    counts.readings += p.covered.readings;
    counts.outside += p.covered.readings - p.covered.seen;
    (p.together ? nearest::keep_simd : nearest::keep_plain)(p.covered, columns, registered.data());
  }
  for (std::uint16_t& pixel : registered) ++pixel;  // nothing becomes 0
  return counts;
}

}  // namespace onemap::hal::imaging
