#pragma once
#include <vector>

#include "mapping/geometry.hpp"
#include "mapping/local/features.hpp"

namespace onemap::mapping {

// The features of one image with where they lie: what two views are compared by. All vectors have the same length.
struct FeatureCloud {
  FeatureSet set;
  std::vector<Eigen::Vector2d> ray;  // undistorted, z = 1
  std::vector<Vector3d> point;       // eq. (5): camera frame, metres; z = 0 where there is no coherent depth

  void reserve(std::size_t capacity) {
    set.reserve(capacity);
    ray.reserve(capacity);
    point.reserve(capacity);
  }
  std::size_t size() const { return set.size(); }
  bool has_depth(std::size_t i) const { return point[i].z() > 0; }
};

}  // namespace onemap::mapping
