#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "hal/depth_noise.hpp"
#include "mapping/local/ray_table.hpp"
#include "support/poses.hpp"

// Depth images of scenes made of planes, by exact ray casting: independent truth for geometry tests.
namespace onemap::test {

// The half space n.p <= h is free; its border is seen from inside.
struct Plane {
  mapping::Vector3d n;
  double h;
};

// A room 4 x 3 x 3 m about the origin, with a slanted wall so that no direction is like another.
inline std::vector<Plane> box_room() {
  const mapping::Vector3d slanted = mapping::Vector3d(0.6, 0.3, 1).normalized();
  return {{{1, 0, 0}, 2},   {{-1, 0, 0}, 2}, {{0, 1, 0}, 1.2}, {{0, -1, 0}, 1.3},
          {{0, 0, 1}, 2.5}, {{0, 0, -1}, 1}, {slanted, 1.8}};
}

// Depth seen from T_world_camera inside the convex scene, in units of 1 / depth_scale; noise of the model where asked.
inline std::vector<std::uint16_t> cast_depth(const std::vector<Plane>& scene, const hal::Intrinsics& k,
                                             const mapping::RayTable& rays, const mapping::Pose& T_world_camera,
                                             Random* noise = nullptr, const hal::DepthNoise& model = {}) {
  std::vector<std::uint16_t> depth(static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height));
  std::size_t i = 0;
  for (int v = 0; v < k.height; ++v) {
    const float* row = rays.row(v);
    for (int u = 0; u < k.width; ++u, ++i) {
      const mapping::Vector3d ray = T_world_camera.R * mapping::Vector3d(row[2 * u], row[2 * u + 1], 1);
      double z = std::numeric_limits<double>::infinity();
      for (const Plane& plane : scene) {
        const double along = plane.n.dot(ray);
        if (along > 1e-9) z = std::min(z, (plane.h - plane.n.dot(T_world_camera.t)) / along);
      }
      if (noise != nullptr) z += noise->normal(model.sigma_m(z));
      if (z > 0 && z * k.depth_scale < 65535) depth[i] = static_cast<std::uint16_t>(z * k.depth_scale + 0.5);
    }
  }
  return depth;
}

}  // namespace onemap::test
