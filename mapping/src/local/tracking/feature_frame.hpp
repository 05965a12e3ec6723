#pragma once
#include <cstdint>
#include <vector>

#include "hal/frame.hpp"
#include "mapping/geometry.hpp"
#include "mapping/local/features.hpp"
#include "mapping/local/point_cloud.hpp"

namespace onemap::mapping {

// One image's features with what the tracker adds: viewing rays, depths and the landmarks that they observe.
struct FeatureFrame {
  FeatureSet set;
  std::vector<Eigen::Vector2d> ray;    // undistorted, z = 1
  std::vector<double> depth_m;         // 0 = no coherent reading
  std::vector<std::int32_t> landmark;  // index into the landmark pool, -1 = none

  void reserve(std::size_t capacity);
  std::size_t size() const { return set.size(); }
  bool has_depth(std::size_t i) const { return depth_m[i] > 0; }
  // Eq. (5): the feature as a point in the camera's frame; only with depth.
  Vector3d point(std::size_t i) const { return {ray[i].x() * depth_m[i], ray[i].y() * depth_m[i], depth_m[i]}; }
};

// Fills ray, depth_m (depths outside kMinDepth_m..kMaxDepth_m do not count) and landmark (-1) for set.
void attach_geometry(FeatureFrame& frame, std::span<const std::uint16_t> depth, const RayTable& rays,
                     double depth_scale);

}  // namespace onemap::mapping
