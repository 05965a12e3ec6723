#include "mapping/local/mapper_config.hpp"

#include <fmt/format.h>

#include <utility>

#include "hal/lens.hpp"

namespace onemap::mapping {
namespace {

using Limits = LocalMapperLimits;

// Keeps the first thing that is wrong.
class Findings {
 public:
  template <class T>
  void within(const char* place, T value, Range<T> range) {
    require(range.holds(value), place, "{} is not within {} to {}", value, range.least, range.most);
  }
  template <class... Args>
  void require(bool holds, const char* place, fmt::format_string<Args...> reason, Args&&... args) {
    if (!holds && status_) status_ = Error{place, fmt::format(reason, std::forward<Args>(args)...)};
  }
  bool none() const { return status_.ok(); }
  Status take() { return std::move(status_); }

 private:
  Status status_ = success();
};

void check_tracking(const LocalMapperConfig& c, Findings& found) {
  found.within("max_features", c.max_features, Limits::max_features);
  found.within("max_keyframes", c.max_keyframes, Limits::max_keyframes);
  found.within("keyframe_translation_m", c.keyframe_translation_m, Limits::keyframe_translation_m);
  found.within("keyframe_rotation_deg", c.keyframe_rotation_deg, Limits::keyframe_rotation_deg);
  found.within("min_motion_m", c.min_motion_m, Limits::min_motion_m);
  found.within("min_motion_deg", c.min_motion_deg, Limits::min_motion_deg);
}

// In micrometres, as records have them.
void check_truncation(const VoxelMapConfig& map, Findings& found) {
  const std::int64_t voxel_um = map.voxel_um();
  const Range<float> band_m{map.voxel_m, 1000.0f};  // so that it has micrometres at all
  const auto [least, most] = Limits::truncation_voxels;
  const bool holds = band_m.holds(map.truncation_m) && map.truncation_um() >= least * voxel_um &&
                     map.truncation_um() <= most * voxel_um;
  found.require(holds, "map.truncation_m", "{} is not within {} to {} voxels of {} m", map.truncation_m, least, most,
                map.voxel_m);
}

void check_map(const VoxelMapConfig& map, Findings& found) {
  found.within("map.voxel_m", map.voxel_m, Limits::voxel_m);
  found.within("map.max_depth_m", map.max_depth_m, Limits::max_depth_m);
  found.within("map.budget_bytes", map.budget_bytes, Limits::budget_bytes);
  if (found.none()) check_truncation(map, found);
}

void check_camera(const hal::Intrinsics& k, Findings& found) {
  found.within("camera.width", k.width, Limits::image_side_px);
  found.within("camera.height", k.height, Limits::image_side_px);
  found.require(!found.none() || PinholeView::numbers_pixels_exactly(k.width, k.height), "camera.width",
                "{} x {} are too many pixels", k.width, k.height);
  const Range<double> focal_px{Limits::focal_length_widths.least * k.width, Limits::focal_length_widths.most * k.width};
  found.within("camera.fx", k.fx, focal_px);
  found.within("camera.fy", k.fy, focal_px);
  found.within("camera.cx", k.cx, Range<double>{-0.5, k.width - 0.5});
  found.within("camera.cy", k.cy, Range<double>{-0.5, k.height - 0.5});
  found.within("camera.depth_scale", k.depth_scale, Limits::depth_scale);
}

void check_lens(const hal::Intrinsics& k, Findings& found) {
  constexpr int kSteps = 16;
  for (int j = 0; j <= kSteps; ++j)
    for (int i = 0; i <= kSteps; ++i) {
      const int u = i * (k.width - 1) / kSteps, v = j * (k.height - 1) / kSteps;
      const hal::Point2 pixel{static_cast<double>(u), static_cast<double>(v)};
      found.require(hal::has_ray(k, pixel), "camera.k1 k2 p1 p2 k3", "the lens has no ray for pixel ({}, {})", u, v);
    }
}

}  // namespace

Status check(const LocalMapperConfig& config, const hal::Intrinsics& camera) {
  Findings found;
  check_tracking(config, found);
  check_map(config.map, found);
  check_camera(camera, found);
  if (!found.none()) return found.take();
  check_lens(camera, found);
  VoxelMapConfig map = config.map;
  map.image_pixels = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  found.require(VoxelMap::capacity_of(map) > 0, "map.budget_bytes",
                "{} has no room for a block beside an image of {}x{}", map.budget_bytes, camera.width, camera.height);
  return found.take();
}

}  // namespace onemap::mapping
