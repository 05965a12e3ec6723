#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "hal/frame.hpp"
#include "mapping/local/ray_table.hpp"

namespace onemap::test {

using mapping::Matrix3d;
using mapping::Pose;
using mapping::RayTable;
using mapping::Vector3d;

struct Sphere {
  Vector3d centre = Vector3d::Zero();
  double radius_m = 0;
};

// A room (the inside of a box) with spheres: a surface that is known exactly.
struct Scene {
  Vector3d room_min = Vector3d(-1.5, -1.2, -1.0), room_max = Vector3d(1.7, 1.3, 1.4);
  std::vector<Sphere> spheres;

  // Distance from the nearest surface, metres.
  double distance(const Vector3d& p) const {
    double out = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 3; ++i) out = std::min({out, std::abs(p[i] - room_min[i]), std::abs(p[i] - room_max[i])});
    for (const Sphere& s : spheres) out = std::min(out, std::abs((p - s.centre).norm() - s.radius_m));
    return out;
  }
  // Unit normal towards free space of the surface nearest to p.
  Vector3d normal(const Vector3d& p) const {
    const double nearest = distance(p);
    for (const Sphere& s : spheres)
      if (std::abs((p - s.centre).norm() - s.radius_m) <= nearest) return (p - s.centre).normalized();
    Vector3d out = Vector3d::Zero();
    for (int i = 0; i < 3; ++i) {
      if (std::abs(p[i] - room_min[i]) <= nearest) return out[i] = 1, out;
      if (std::abs(p[i] - room_max[i]) <= nearest) return out[i] = -1, out;
    }
    return out;
  }
  // Length of the ray from p (inside the room) along d until it hits, in units of |d|.
  double cast(const Vector3d& p, const Vector3d& d) const {
    double out = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 3; ++i)
      if (d[i] != 0) out = std::min(out, ((d[i] > 0 ? room_max[i] : room_min[i]) - p[i]) / d[i]);
    for (const Sphere& s : spheres) {
      const Vector3d m = p - s.centre;
      const double a = d.dot(d), b = m.dot(d), c = m.dot(m) - s.radius_m * s.radius_m, root = b * b - a * c;
      if (root < 0) continue;
      const double t = (-b - std::sqrt(root)) / a;
      if (t > 0) out = std::min(out, t);
    }
    return out;
  }
  // A smooth colour for every place.
  static std::uint8_t color(const Vector3d& p, int channel) {
    const double x = 0.5 + 0.4 * (p[channel] - std::floor(p[channel])) * (channel == 1 ? -1 : 1);
    return static_cast<std::uint8_t>(255 * std::clamp(x, 0.0, 1.0));
  }
};

// An image with its memory, as a camera would deliver it.
struct RenderedFrame {
  hal::Intrinsics intrinsics;
  std::vector<std::uint8_t> rgb;
  std::vector<std::uint16_t> depth;
  Pose T_world_camera;
  hal::FrameView view() const { return {{}, {}, 0, &intrinsics, rgb, depth}; }
};

inline RenderedFrame render(const Scene& scene, const hal::Intrinsics& k, const RayTable& rays,
                            const Pose& T_world_camera) {
  RenderedFrame out{k, {}, {}, T_world_camera};
  for (int v = 0; v < k.height; ++v)
    for (int u = 0; u < k.width; ++u) {
      const Vector3d ray(static_cast<double>(rays.row(v)[2 * u]), static_cast<double>(rays.row(v)[2 * u + 1]), 1);
      const Vector3d d = T_world_camera.R * ray;
      const double z = scene.cast(T_world_camera.t, d);
      out.depth.push_back(static_cast<std::uint16_t>(std::min(65535.0, z * k.depth_scale + 0.5)));
      for (int c = 0; c < 3; ++c) out.rgb.push_back(Scene::color(T_world_camera.t + z * d, c));
    }
  return out;
}

// A camera at `eye` that looks at `target`, y roughly along -up.
inline Pose look_at(const Vector3d& eye, const Vector3d& target, const Vector3d& up = Vector3d(0, 0, 1)) {
  const Vector3d z = (target - eye).normalized();
  const Vector3d x = z.cross(up).normalized();
  Pose out;
  out.R.col(0) = x;
  out.R.col(1) = z.cross(x);
  out.R.col(2) = z;
  out.t = eye;
  return out;
}

// A quarter of VGA with the field of view of a usual depth camera.
inline hal::Intrinsics small_camera(bool distorted = false) {
  hal::Intrinsics k;
  k.width = 320;
  k.height = 240;
  k.fx = k.fy = 262;
  k.cx = 159.5;
  k.cy = 119.5;
  if (distorted) {
    k.k1 = 0.26;
    k.k2 = -0.95;
    k.p1 = -0.005;
    k.p2 = 0.003;
    k.k3 = 1.16;
  }
  return k;
}

}  // namespace onemap::test
