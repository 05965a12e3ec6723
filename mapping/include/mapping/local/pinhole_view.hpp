#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "hal/frame.hpp"
#include "mapping/local/depth_smoother.hpp"
#include "mapping/local/ray_table.hpp"

namespace onemap::mapping {

// A depth image resampled (nearest pixel) to an ideal pinhole of the same size that spans the whole undistorted field
// of view, with a border of one empty pixel, so that projecting a point is a pinhole projection and one look-up. The
// pixel of the ray (x, y, 1) is (floor(fx x + cx), floor(fy y + cy)): border and half a pixel are in cx and cy.
class PinholeView {
 public:
  explicit PinholeView(std::size_t max_pixels);
  // Depths outside [kMinDepth_m, max_depth_m] become 0, and from 2 m on those that lie on a plane with all of their
  // neighbours (5 x 5) become what it says there. The look-up table is kept while the intrinsics stay the same.
  // simd false: the plain twin, which gives the same bytes.
  void load(const hal::FrameView& frame, const RayTable& rays, float max_depth_m, bool simd = true);

  int width() const { return width_; }    // border included
  int height() const { return height_; }  // border included
  float fx() const { return fx_; }
  float fy() const { return fy_; }
  float cx() const { return cx_; }
  float cy() const { return cy_; }
  // width x height, 0 = none; farther than max_depth_m: negative, and not to be fused
  const float* depth_m() const { return depth_m_.data(); }
  const std::int32_t* source() const { return source_.data(); }  // pixel index in the frame, -1 = outside
  std::size_t bytes() const;
  static std::size_t bytes_for(std::size_t max_pixels);
  // Whether the number of each pixel, border included, is exact as a float: fusion computes it as one.
  static bool numbers_pixels_exactly(int image_width, int image_height);

 private:
  void build(const hal::Intrinsics& intrinsics, const RayTable& rays);

  hal::Intrinsics intrinsics_;
  bool built_ = false;
  bool in_place_ = false;  // a lens without distortion: each pixel is where it was
  int width_ = 0, height_ = 0;
  float fx_ = 0, fy_ = 0, cx_ = 0, cy_ = 0;
  std::vector<float> depth_m_;
  std::vector<std::int32_t> source_;
  DepthSmoother smoother_;
};

}  // namespace onemap::mapping
