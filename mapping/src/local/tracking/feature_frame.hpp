#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mapping/local/feature_cloud.hpp"
#include "mapping/local/ray_table.hpp"

namespace onemap::mapping {

// One image's features with the landmarks that they observe.
struct FeatureFrame : FeatureCloud {
  std::vector<std::int32_t> landmark;  // index into the landmark pool, -1 = none

  void reserve(std::size_t capacity) {
    FeatureCloud::reserve(capacity);
    landmark.reserve(capacity);
  }
  double inverse_depth(std::size_t i) const { return has_depth(i) ? 1 / point[i].z() : 0.0; }  // 1/m, 0 = none
};

// Fills ray, point (depths outside kMinDepth_m..kMaxDepth_m do not count) and landmark (-1) for set. T_colour_depth:
// how the camera moved between the two images; the points are where it was when the features were seen.
void attach_geometry(FeatureFrame& frame, std::span<const std::uint16_t> depth, const RayTable& rays,
                     const hal::Intrinsics& intrinsics, const std::optional<Pose>& T_colour_depth = {});

// Copies without allocating: to's vectors have the capacity.
void copy_features(const FeatureFrame& from, FeatureFrame& to);

}  // namespace onemap::mapping
