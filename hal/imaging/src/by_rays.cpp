#include "by_rays.hpp"

#include <algorithm>

#include "hal/imaging/image_size.hpp"
#include "hal/lens.hpp"
#include "nearest.hpp"

namespace onemap::hal::imaging {

namespace {

constexpr float kMostTogether = 1.1f;  // colour pixels of a depth pixel: neighbours of finer images lie apart

// Whether the colour image sees nothing along this ray, however far the reading. Between the nearest depth that counts
// and the farthest value there is, the row v that it falls on goes one way only (a ratio of two lines), and so does the
// half of what it covers: the ends say all.
bool is_beside(const footprints::Rig& rig, double ray_y, double ray_z) {
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

ByRays::ByRays(const footprints::Rig& rig, const Intrinsics& depth, const std::array<double, 9>& r)
    : rig_(rig),
      width_(static_cast<std::size_t>(depth.width)),
      covered_(width_),
      simd_(simd_available()),
      together_(simd_ && rig.finer_u < kMostTogether) {
  for (std::vector<float>* all : {&x_, &y_, &z_}) all->reserve(size_of(depth).pixels());
  for (int v = 0; v < depth.height; ++v) {
    bool blind = true;
    for (int u = 0; u < depth.width; ++u) {
      const Point2 ray = ray_of(depth, {static_cast<double>(u), static_cast<double>(v)});
      x_.push_back(static_cast<float>(r[0] * ray.x + r[1] * ray.y + r[2]));
      y_.push_back(static_cast<float>(r[3] * ray.x + r[4] * ray.y + r[5]));
      z_.push_back(static_cast<float>(r[6] * ray.x + r[7] * ray.y + r[8]));
      blind = blind && is_beside(rig, y_.back(), z_.back());
    }
    blind_.push_back(blind);
  }
}

DepthRegistration::Counts ByRays::apply(std::span<const std::uint16_t> depth, std::uint16_t* registered) {
  const auto columns = static_cast<std::size_t>(rig_.width);
  DepthRegistration::Counts counts;
  for (std::size_t at = 0; at < depth.size(); at += width_) {
    if (blind_[at / width_]) {
      counts.add_unseen(depth.subspan(at, width_));
      continue;
    }
    const footprints::Row row{depth.subspan(at, width_), &x_[at], &y_[at], &z_[at]};
    (simd_ ? footprints::find_simd : footprints::find_plain)(rig_, row, covered_);
    counts.readings += static_cast<std::uint64_t>(covered_.readings);
    counts.outside += static_cast<std::uint64_t>(covered_.readings - covered_.seen);
    (together_ ? nearest::keep_simd : nearest::keep_plain)(covered_, columns, registered);
  }
  return counts;
}

}  // namespace onemap::hal::imaging
