#include "mapping/local/pinhole_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "hal/lens.hpp"

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

}  // namespace

PinholeView::PinholeView(std::size_t max_pixels) {
  depth_m_.reserve(padded(max_pixels));
  source_.reserve(padded(max_pixels));
}

std::size_t PinholeView::bytes_for(std::size_t max_pixels) {
  return padded(max_pixels) * (sizeof(float) + sizeof(std::int32_t));
}

bool PinholeView::numbers_pixels_exactly(int image_width, int image_height) {
  return (std::int64_t{image_width} + 2) * (std::int64_t{image_height} + 2) <= std::int64_t{1} << 24;
}

std::size_t PinholeView::bytes() const {
  return depth_m_.capacity() * sizeof(float) + source_.capacity() * sizeof(std::int32_t);
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

void PinholeView::load(const hal::FrameView& frame, const RayTable& rays, float max_depth_m) {
  if (!built_ || !same(*frame.intrinsics, intrinsics_)) build(*frame.intrinsics, rays);
  const float metres = static_cast<float>(1.0 / frame.intrinsics->depth_scale);
  const float farthest = std::min(max_depth_m, kMaxDepth_m);
  const auto checked = [&](float z) { return static_cast<int>(z >= kMinDepth_m) & static_cast<int>(z <= farthest); };
  if (!in_place_) {
    for (std::size_t i = 0, n = depth_m_.size(); i < n; ++i) {
      const std::int32_t from = source_[i];
      const float z = from < 0 ? 0.f : metres * static_cast<float>(frame.depth[static_cast<std::size_t>(from)]);
      depth_m_[i] = checked(z) != 0 ? z : 0.f;
    }
    return;
  }
  const auto columns = static_cast<std::size_t>(intrinsics_.width);
  const std::uint16_t* from = frame.depth.data();
  for (std::size_t v = 1; v + 1 < static_cast<std::size_t>(height_); ++v, from += columns) {
    float* to = &depth_m_[v * static_cast<std::size_t>(width_) + 1];
    for (std::size_t u = 0; u < columns; ++u) {
      const float z = metres * static_cast<float>(from[u]);
      to[u] = checked(z) != 0 ? z : 0.f;
    }
  }
}

}  // namespace onemap::mapping
