#include "hal/imaging/register_depth.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>

#include "hal/imaging/image_size.hpp"
#include "hal/lens.hpp"

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
      const Point2 ray = ray_of(k, {u, v});
      widest = std::max(widest, ray.x * ray.x + ray.y * ray.y);
    }
  return static_cast<float>(1.1 * widest);
}

// The pixel centres within half of a middle, cut at the image's side: [first, end). No branch and no call, so that the
// compiler makes vectors of it.
void centres_around(float middle, float half, float size, std::int32_t& first, std::int32_t& end) {
  const float low = std::min(std::max(middle - half, 0.0f), size);
  const float high = std::min(std::max(middle + half, 0.0f), size);
  const auto low_whole = static_cast<std::int32_t>(low), high_whole = static_cast<std::int32_t>(high);
  first = low_whole + (static_cast<float>(low_whole) < low ? 1 : 0);
  end = high_whole + (static_cast<float>(high_whole) < high ? 1 : 0);
}

// The lens of the colour camera in single precision: a twin of pixel_of() that becomes vectors, tested equal to it.
struct ColourLens {
  explicit ColourLens(const Intrinsics& k)
      : fx(static_cast<float>(k.fx)),
        fy(static_cast<float>(k.fy)),
        cx(static_cast<float>(k.cx)),
        cy(static_cast<float>(k.cy)),
        k1(static_cast<float>(k.k1)),
        k2(static_cast<float>(k.k2)),
        p1(static_cast<float>(k.p1)),
        p2(static_cast<float>(k.p2)),
        k3(static_cast<float>(k.k3)) {}
  float fx, fy, cx, cy, k1, k2, p1, p2, k3;

  // Where a ray (x, y, 1) is imaged, and whether the lens says so: 1 or 0.
  template <bool distorted>
  float image(float x, float y, float widest, float& u, float& v) const {
    if constexpr (distorted) {
      const float r2 = x * x + y * y, grown = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
      u = fx * (x * grown + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + cx;
      v = fy * (y * grown + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + cy;
      return r2 <= widest ? 1.0f : 0.0f;
    } else {
      u = fx * x + cx;
      v = fy * y + cy;
      return 1.0f;
    }
  }
};

// What a row needs, and where it goes.
struct RowInput {
  const std::uint16_t* depth;
  const float *ray_x, *ray_y, *ray_z;
  std::array<float, 3> t_m;
  float metres, offset_m;  // of a depth value, and added to it
  float scale;             // colour's depth values of a metre
  float finer_u, finer_v;  // colour pixels of a depth pixel at the same distance
  float widest;
  float nearest_m;
};

// No branch and no call in the loop, so that the compiler makes vectors of it: what is no place in the image gets value
// 0.
template <bool distorted>
void place_row(const ColourLens& lens, const RowInput& in, std::size_t n, float* __restrict u, float* __restrict v,
               float* __restrict half_u, float* __restrict half_v, float* __restrict value) {
  // Not the constant itself: the compiler would know its inverse, and take a branch for it.
  const float nearest = in.nearest_m;
  const float tx = in.t_m[0], ty = in.t_m[1], tz = in.t_m[2];
  const float offset = in.offset_m;
  const float half_finer_u = 0.5f * in.finer_u, half_finer_v = 0.5f * in.finer_v;
  for (std::size_t i = 0; i < n; ++i) {
    const float z_m = static_cast<float>(in.depth[i]) * in.metres + offset;
    const float x = in.ray_x[i] * z_m + tx, y = in.ray_y[i] * z_m + ty, z = in.ray_z[i] * z_m + tz;
    const float inverse = 1 / (z > nearest ? z : nearest);
    const float known = lens.image<distorted>(x * inverse, y * inverse, in.widest, u[i], v[i]);
    half_u[i] = half_finer_u * (z_m * inverse) + kMargin_px;
    half_v[i] = half_finer_v * (z_m * inverse) + kMargin_px;
    value[i] = known * (z * in.scale + 0.5f);
  }
}

}  // namespace

DepthRegistration::DepthRegistration(const Intrinsics& depth, const Intrinsics& colour, const ColourFromDepth& pose,
                                     double offset_m)
    : depth_(depth),
      colour_(colour),
      t_m_(as_float(pose.translation_m)),
      offset_m_(static_cast<float>(offset_m)),
      distorted_(has_distortion(colour)),
      widest_(widest_ray(colour)) {
  const auto& r = pose.rotation;
  for (std::vector<float>* rays : {&ray_x_, &ray_y_, &ray_z_}) rays->reserve(size_of(depth).pixels());
  for (int v = 0; v < depth.height; ++v)
    for (int u = 0; u < depth.width; ++u) {
      const Point2 ray = ray_of(depth, {static_cast<double>(u), static_cast<double>(v)});
      ray_x_.push_back(static_cast<float>(r[0] * ray.x + r[1] * ray.y + r[2]));
      ray_y_.push_back(static_cast<float>(r[3] * ray.x + r[4] * ray.y + r[5]));
      ray_z_.push_back(static_cast<float>(r[6] * ray.x + r[7] * ray.y + r[8]));
    }
  const auto width = static_cast<std::size_t>(depth.width);
  for (std::vector<float>* column : {&row_.u, &row_.v, &row_.half_u, &row_.half_v, &row_.value}) column->resize(width);
  Footprints& f = footprints_;
  for (std::vector<std::int32_t>* column : {&f.u0, &f.v0, &f.u1, &f.v1, &f.value}) column->resize(width);
}

void DepthRegistration::place(std::size_t row, std::span<const std::uint16_t> depth) {
  const std::size_t at = row * depth.size();
  const RowInput in{depth.data(),
                    &ray_x_[at],
                    &ray_y_[at],
                    &ray_z_[at],
                    t_m_,
                    static_cast<float>(1 / depth_.depth_scale),
                    offset_m_,
                    static_cast<float>(colour_.depth_scale),
                    static_cast<float>(colour_.fx / depth_.fx),
                    static_cast<float>(colour_.fy / depth_.fy),
                    widest_,
                    kNearest_m};
  const auto run = distorted_ ? place_row<true> : place_row<false>;
  run(ColourLens(colour_), in, depth.size(), row_.u.data(), row_.v.data(), row_.half_u.data(), row_.half_v.data(),
      row_.value.data());
}

void DepthRegistration::cover() {
  const auto width = static_cast<float>(colour_.width), height = static_cast<float>(colour_.height);
  Footprints& f = footprints_;
  for (std::size_t i = 0; i < f.value.size(); ++i) {
    centres_around(row_.u[i], row_.half_u[i], width, f.u0[i], f.u1[i]);
    centres_around(row_.v[i], row_.half_v[i], height, f.v0[i], f.v1[i]);
    f.value[i] = static_cast<std::int32_t>(std::min(std::max(row_.value[i], 0.0f), 65536.0f));
  }
}

void DepthRegistration::keep_nearest(std::span<const std::uint16_t> depth, std::span<std::uint16_t> registered,
                                     Counts& counts) const {
  const Footprints& f = footprints_;
  const auto columns = static_cast<std::size_t>(colour_.width);
  const int least =
      std::max(1, static_cast<int>(std::lround(kNearest_m * static_cast<float>(colour_.depth_scale))) + 1);
  for (std::size_t i = 0; i < depth.size(); ++i) {
    if (depth[i] == 0) continue;
    ++counts.readings;
    const int wide = f.u1[i] - f.u0[i], high = f.v1[i] - f.v0[i], value = f.value[i];
    if (wide < 1 || high < 1 || wide > kWidest_px || high > kWidest_px || value < least || value > 65535) {
      ++counts.outside;
      continue;
    }
    std::uint16_t* pixel = &registered[static_cast<std::size_t>(f.v0[i]) * columns + static_cast<std::size_t>(f.u0[i])];
    for (int v = 0; v < high; ++v, pixel += columns)
      for (int u = 0; u < wide; ++u)
        if (pixel[u] == 0 || value < pixel[u]) pixel[u] = static_cast<std::uint16_t>(value);
  }
}

DepthRegistration::Counts DepthRegistration::apply(std::span<const std::uint16_t> depth,
                                                   std::span<std::uint16_t> registered) {
  assert(depth.size() == size_of(depth_).pixels() && registered.size() == size_of(colour_).pixels());
  Counts counts;
  std::fill(registered.begin(), registered.end(), std::uint16_t{0});
  const auto width = static_cast<std::size_t>(depth_.width);
  for (std::size_t row = 0; row < static_cast<std::size_t>(depth_.height); ++row) {
    const auto readings = depth.subspan(row * width, width);
    place(row, readings);
    cover();
    keep_nearest(readings, registered, counts);
  }
  return counts;
}

}  // namespace onemap::hal::imaging
