#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "hal/frame.hpp"
#include "mapping/geometry.hpp"
#include "mapping/local/depth_range.hpp"

namespace onemap::mapping {

// For every pixel the undistorted viewing ray with z = 1: (x, y) such that X = x * depth, Y = y * depth, Z = depth
// (eq. 5 with the lens distortion taken out). Computed once a camera.
class RayTable {
 public:
  explicit RayTable(const hal::Intrinsics& intrinsics);
  int width() const { return width_; }
  int height() const { return height_; }
  // Rays of row v: 2 * width floats, x and y interleaved.
  const float* row(int v) const { return &rays_[2 * static_cast<std::size_t>(v) * static_cast<std::size_t>(width_)]; }
  // The ray of a sub-pixel position (bilinear between pixels).
  Eigen::Vector2d at(double u_px, double v_px) const;
  std::size_t bytes() const { return rays_.capacity() * sizeof(float); }

 private:
  int width_, height_;
  std::vector<float> rays_;
};

// Which pixels to_points() takes: every stride-th in both directions, with a depth of kMinDepth_m to farthest_m.
struct PointSampling {
  int stride = 1;
  float farthest_m = kMaxDepth_m;
};

// Eq. (5) for the sampled pixels of a depth image. Writes at most out.size() points (camera frame, metres) and returns
// how many.
std::size_t to_points(std::span<const std::uint16_t> depth, const RayTable& rays, double depth_scale,
                      const PointSampling& sampling, std::span<Vector3f> out);

}  // namespace onemap::mapping
