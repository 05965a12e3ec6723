#include "hal/imaging/register_depth.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "hal/imaging/image_size.hpp"
#include "hal/imaging/lens.hpp"

namespace onemap::hal::imaging {

namespace {

// Neighbouring readings of a slanted surface move by a little more or less than a pixel: without a margin there would
// be slits between them.
constexpr float kMargin_px = 0.1f;
constexpr float kNearest_m = 0.01f;
constexpr int kWidest_px = 64;  // of what one reading covers: more is no surface but two cameras that look apart

std::array<float, 3> as_float(const std::array<double, 3>& t) {
  return {static_cast<float>(t[0]), static_cast<float>(t[1]), static_cast<float>(t[2])};
}

float widest_ray(const Intrinsics& k) {
  double widest = 0;
  for (const double u : {-0.5, k.width - 0.5})
    for (const double v : {-0.5, k.height - 0.5}) {
      const Point ray = ray_of(k, {u, v});
      widest = std::max(widest, ray.x * ray.x + ray.y * ray.y);
    }
  return static_cast<float>(1.1 * widest);
}

// The range of pixel centres between two places in the image, cut at its sides. Both are finite.
void centres_between(float a, float b, int size, int& first, int& end) {
  const float low = std::clamp(std::min(a, b) - kMargin_px, 0.0f, static_cast<float>(size));
  const float high = std::clamp(std::max(a, b) + kMargin_px, 0.0f, static_cast<float>(size));
  first = static_cast<int>(std::ceil(low));
  end = static_cast<int>(std::ceil(high));
}

}  // namespace

DepthRegistration::DepthRegistration(const Intrinsics& depth, const Intrinsics& colour, const ColourFromDepth& pose)
    : depth_(depth),
      colour_(colour),
      t_m_(as_float(pose.translation_m)),
      distorted_(has_distortion(colour)),
      widest_(widest_ray(colour)) {
  const auto& r = pose.rotation;
  corners_.reserve(static_cast<std::size_t>(depth.width + 1) * static_cast<std::size_t>(depth.height + 1));
  for (int v = 0; v <= depth.height; ++v)
    for (int u = 0; u <= depth.width; ++u) {
      const Point ray = ray_of(depth, {u - 0.5, v - 0.5});
      corners_.push_back({static_cast<float>(r[0] * ray.x + r[1] * ray.y + r[2]),
                          static_cast<float>(r[3] * ray.x + r[4] * ray.y + r[5]),
                          static_cast<float>(r[6] * ray.x + r[7] * ray.y + r[8])});
    }
}

bool DepthRegistration::project(const Corner& corner, float z_m, float& u, float& v) const {
  const float x = corner.x * z_m + t_m_[0], y = corner.y * z_m + t_m_[1], z = corner.z * z_m + t_m_[2];
  if (!(z > kNearest_m)) return false;
  const float inverse = 1 / z, ray_x = x * inverse, ray_y = y * inverse;
  if (!(ray_x * ray_x + ray_y * ray_y <= widest_)) return false;
  if (distorted_) {
    const Point pixel = pixel_of(colour_, {ray_x, ray_y});
    u = static_cast<float>(pixel.x);
    v = static_cast<float>(pixel.y);
  } else {
    u = static_cast<float>(colour_.fx) * ray_x + static_cast<float>(colour_.cx);
    v = static_cast<float>(colour_.fy) * ray_y + static_cast<float>(colour_.cy);
  }
  return true;
}

bool DepthRegistration::cover(const Corner& first, const Corner& last, float z_m, Footprint& out) const {
  float u0, v0, u1, v1;
  if (!project(first, z_m, u0, v0) || !project(last, z_m, u1, v1)) return false;
  centres_between(u0, u1, colour_.width, out.u0, out.u1);
  centres_between(v0, v1, colour_.height, out.v0, out.v1);
  if (out.u0 >= out.u1 || out.v0 >= out.v1) return false;
  if (out.u1 - out.u0 > kWidest_px || out.v1 - out.v0 > kWidest_px) return false;
  const float value = (0.5f * (first.z + last.z) * z_m + t_m_[2]) * static_cast<float>(colour_.depth_scale) + 0.5f;
  if (!(value >= 1 && value < 65536)) return false;
  out.value = static_cast<std::uint16_t>(value);
  return true;
}

DepthRegistration::Counts DepthRegistration::apply(std::span<const std::uint16_t> depth,
                                                   std::span<std::uint16_t> registered) const {
  assert(depth.size() == size_of(depth_).pixels() && registered.size() == size_of(colour_).pixels());
  Counts counts;
  std::fill(registered.begin(), registered.end(), std::uint16_t{0});
  const float metres = static_cast<float>(1 / depth_.depth_scale);
  const auto width = static_cast<std::size_t>(depth_.width), columns = static_cast<std::size_t>(colour_.width);
  for (std::size_t i = 0; i < depth.size(); ++i) {
    if (depth[i] == 0) continue;
    ++counts.readings;
    const Corner* first = &corners_[i + i / width];  // a row has one corner more than pixels
    Footprint f;
    if (!cover(*first, first[width + 2], static_cast<float>(depth[i]) * metres, f)) {
      ++counts.outside;
      continue;
    }
    for (int v = f.v0; v < f.v1; ++v)
      for (int u = f.u0; u < f.u1; ++u) {
        std::uint16_t& pixel = registered[static_cast<std::size_t>(v) * columns + static_cast<std::size_t>(u)];
        if (pixel == 0 || f.value < pixel) pixel = f.value;
      }
  }
  return counts;
}

}  // namespace onemap::hal::imaging
