#include "mapping/local/pinhole_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "hal/lens.hpp"
#include "local/read_depth.hpp"
#include "mapping/local/depth_range.hpp"

namespace onemap::mapping {
namespace {

bool same(const hal::Intrinsics& a, const hal::Intrinsics& b) {
  const auto values = [](const hal::Intrinsics& k) {
    return std::array{k.fx, k.fy, k.cx, k.cy, k.k1, k.k2, k.p1, k.p2, k.k3};
  };
  return a.width == b.width && a.height == b.height && values(a) == values(b);
}

struct Extent {
  double x0 = 1e9, x1 = -1e9, y0 = 1e9, y1 = -1e9;
  void add(const float* ray) {
    x0 = std::min<double>(x0, ray[0]);
    x1 = std::max<double>(x1, ray[0]);
    y0 = std::min<double>(y0, ray[1]);
    y1 = std::max<double>(y1, ray[1]);
  }
};

// The field of view: the rays of the image's border.
Extent field_of_view(const RayTable& rays) {
  Extent out;
  for (int u = 0; u < rays.width(); ++u) {
    out.add(rays.row(0) + 2 * u);
    out.add(rays.row(rays.height() - 1) + 2 * u);
  }
  for (int v = 0; v < rays.height(); ++v) {
    out.add(rays.row(v));
    out.add(rays.row(v) + 2 * (rays.width() - 1));
  }
  return out;
}

// Index of the pixel nearest to where the lens images the ray (x, y, 1), -1 outside.
std::int32_t index_of_pixel(const hal::Intrinsics& k, hal::Point2 ray) {
  const hal::Point2 px = hal::pixel_of(k, ray);
  const double u = px.x + 0.5, v = px.y + 0.5;
  if (!(u >= 0 && v >= 0 && u < k.width && v < k.height)) return -1;
  return static_cast<std::int32_t>(v) * k.width + static_cast<std::int32_t>(u);
}

// A border of one pixel on each side of an image of max_pixels, for every usual shape.
std::size_t padded(std::size_t max_pixels) { return max_pixels == 0 ? 0 : max_pixels + max_pixels / 64 + 4096; }

std::size_t rows(std::size_t max_pixels) { return max_pixels == 0 ? 0 : 2048; }

}  // namespace

PinholeView::PinholeView(std::size_t max_pixels) : smoother_(rows(max_pixels)) {
  depth_m_.reserve(padded(max_pixels));
  source_.reserve(padded(max_pixels));
}

std::size_t PinholeView::bytes_for(std::size_t max_pixels) {
  return padded(max_pixels) * (sizeof(float) + sizeof(std::int32_t)) + DepthSmoother::bytes_for(rows(max_pixels));
}

bool PinholeView::numbers_pixels_exactly(int image_width, int image_height) {
  return (std::int64_t{image_width} + 2) * (std::int64_t{image_height} + 2) <= std::int64_t{1} << 24;
}

std::size_t PinholeView::bytes() const {
  return depth_m_.capacity() * sizeof(float) + source_.capacity() * sizeof(std::int32_t) + smoother_.bytes();
}

void PinholeView::build(const hal::Intrinsics& intrinsics, const RayTable& rays) {
  intrinsics_ = intrinsics;
  built_ = true;
  width_ = intrinsics.width + 2;
  height_ = intrinsics.height + 2;
  const auto size = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  depth_m_.assign(size, 0.f);
  source_.assign(size, -1);
  const Extent view = field_of_view(rays);
  const double fx = (intrinsics.width - 1) / (view.x1 - view.x0), fy = (intrinsics.height - 1) / (view.y1 - view.y0);
  fx_ = static_cast<float>(fx);
  fy_ = static_cast<float>(fy);
  cx_ = static_cast<float>(1.5 - view.x0 * fx);
  cy_ = static_cast<float>(1.5 - view.y0 * fy);
  in_place_ = true;
  for (int v = 1; v + 1 < height_; ++v)
    for (int u = 1; u + 1 < width_; ++u) {
      const int i = v * width_ + u;
      const std::int32_t from = index_of_pixel(intrinsics, {view.x0 + (u - 1) / fx, view.y0 + (v - 1) / fy});
      source_[static_cast<std::size_t>(i)] = from;
      in_place_ = in_place_ && from == (v - 1) * intrinsics.width + u - 1;
    }
}

void PinholeView::load(const hal::FrameView& frame, const RayTable& rays, float max_depth_m, bool simd) {
  if (!built_ || !same(*frame.intrinsics, intrinsics_)) build(*frame.intrinsics, rays);
  const DepthUnits units{static_cast<float>(1.0 / frame.intrinsics->depth_scale), std::min(max_depth_m, kMaxDepth_m)};
  if (in_place_) {
    const auto columns = static_cast<std::size_t>(intrinsics_.width);
    for (std::size_t v = 0; v < static_cast<std::size_t>(intrinsics_.height); ++v)
      read_depth(frame.depth.subspan(v * columns, columns), units,
                 &depth_m_[(v + 1) * static_cast<std::size_t>(width_) + 1]);
  } else {
    look_up_depth(frame.depth, source_, units, simd, depth_m_.data());
  }
  smoother_.smooth(depth_m_.data(), width_, height_, simd);
}

}  // namespace onemap::mapping
