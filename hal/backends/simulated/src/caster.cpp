#include "caster.hpp"

#include <algorithm>
#include <cmath>

namespace onemap::hal::simulated {

namespace {

constexpr double kNearest = 0.05;   // metres; nothing nearer is drawn
constexpr double kOverlap = 2e-6;   // metres a patch reaches over its edge, so that no gap opens along shared edges
constexpr float kGrazing2 = 0.02f;  // cosine squared of the incidence below which no depth comes back (82 degrees)

// Where on a square's perimeter the direction (x, y) points, 0..4, one unit a quarter: an angle without an arctangent.
double square_angle(double x, double y) {
  const double sum = std::abs(x) + std::abs(y);
  if (sum <= 0) return 0;
  const double p = y / sum;
  return x >= 0 ? (p >= 0 ? p : 4 + p) : 2 - p;
}

}  // namespace

Caster::Caster(const Scene& scene, const Intrinsics& intrinsics)
    : scene_(scene), k_(intrinsics), ids_(static_cast<std::size_t>(intrinsics.width)) {
  patches_.reserve(scene.patches.size());
  curved_.reserve(scene.curved.size());
}

Caster::Linear Caster::along(Vec3 d) const {
  return {d.x / k_.fx, d.y / k_.fy, d.z - d.x * k_.cx / k_.fx - d.y * k_.cy / k_.fy};
}

Vec3 Caster::to_camera(Vec3 d) const { return {dot(pose_.right, d), dot(pose_.down, d), dot(pose_.forward, d)}; }

void Caster::start(const CameraPose& pose) {
  pose_ = pose;
  patches_.clear();
  curved_.clear();
  for (const Patch& patch : scene_.patches) see_patch(patch);
  for (const Curved& curved : scene_.curved) see_curved(curved);
}

// Pixels that the corners' hull can cover: all when it crosses the camera's plane, none when it is behind.
Caster::Bounds Caster::bounds_of(const std::array<Vec3, 8>& corners, std::size_t count) const {
  double x0 = k_.width, x1 = -1, y0 = k_.height, y1 = -1;
  std::size_t behind = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 p = corners[i];
    if (p.z < kNearest) {
      ++behind;
      continue;
    }
    const double x = k_.fx * p.x / p.z + k_.cx, y = k_.fy * p.y / p.z + k_.cy;
    x0 = std::min(x0, x);
    x1 = std::max(x1, x);
    y0 = std::min(y0, y);
    y1 = std::max(y1, y);
  }
  if (behind == count) return {};
  if (behind > 0) return {0, 0, k_.width - 1, k_.height - 1};
  const double w = k_.width - 1, h = k_.height - 1;
  return {static_cast<int>(std::clamp(x0 - 1, 0.0, w + 1)), static_cast<int>(std::clamp(y0 - 1, 0.0, h + 1)),
          static_cast<int>(std::clamp(x1 + 2, -1.0, w)), static_cast<int>(std::clamp(y1 + 2, -1.0, h))};
}

void Caster::see_patch(const Patch& patch) {
  const Vec3 origin = to_camera(patch.origin - pose_.position);
  const Vec3 u = to_camera(patch.axis_u), v = to_camera(patch.axis_v), normal = cross(u, v);
  const double g = dot(normal, origin);  // minus the camera's distance in front of the plane
  if (g > -1e-4) return;
  const Vec3 across = patch.size_u * u, up = patch.size_v * v;
  const Bounds bounds = bounds_of({origin, origin + across, origin + up, origin + across + up}, 4);
  if (bounds.empty()) return;
  SeenPatch seen{&patch, &scene_.textures[patch.texture], bounds, along((1 / g) * normal), {}, {}, -g, 0};
  const auto minus = [&](Linear a, double s) {
    return Linear{a.dx - s * seen.w.dx, a.dy - s * seen.w.dy, a.c - s * seen.w.c};
  };
  // The hit z*ray = origin + a*u + b*v; so a/z = u.ray - (u.origin)/z, a straight line in the pixel.
  seen.u = minus(along(u), dot(u, origin));
  seen.v = minus(along(v), dot(v, origin));
  const double texel = seen.texture->texel_m();
  seen.level8 = coarse_log2_256(static_cast<float>(1 / (-g * k_.fx * k_.fy * texel * texel)));
  patches_.push_back(seen);
}

void Caster::see_curved(const Curved& curved) {
  const Vec3 centre = to_camera(curved.base - pose_.position), axis = to_camera({0, 0, 1});
  const double r = curved.radius, low = curved.height > 0 ? 0 : -r, high = curved.height > 0 ? curved.height : r;
  std::array<Vec3, 8> corners;
  for (std::size_t i = 0; i < 8; ++i) {
    const Vec3 corner{(i & 1) != 0 ? r : -r, (i & 2) != 0 ? r : -r, (i & 4) != 0 ? high : low};
    corners[i] = centre + to_camera(corner);
  }
  const Bounds bounds = bounds_of(corners, 8);
  const double h = curved.height > 0 ? dot(centre, axis) : 0;
  const double c = dot(centre, centre) - h * h - r * r;
  if (bounds.empty() || c <= 0) return;
  const Texture& texture = scene_.textures[curved.texture];
  const int level8 = coarse_log2_256(static_cast<float>(1 / (k_.fx * texture.texel_m())));
  curved_.push_back({&curved, &texture, bounds, centre, axis, c, level8});
}

void Caster::cast(int y, Row& row) {
  float* w = row.inverse_depth.data();
  std::fill(row.inverse_depth.begin(), row.inverse_depth.end(), 0.0f);
  std::fill(ids_.begin(), ids_.end(), -1);
  const int patches = static_cast<int>(patches_.size()), all = patches + static_cast<int>(curved_.size());
  for (int i = 0; i < patches; ++i) draw_patch(patches_[static_cast<std::size_t>(i)], i, y, w);
  for (int i = patches; i < all; ++i) draw_curved(curved_[static_cast<std::size_t>(i - patches)], i, y, w);

  const int width = k_.width;
  for (int x = 0; x < width;) {
    const std::int32_t id = ids_[static_cast<std::size_t>(x)];
    int end = x + 1;
    while (end < width && ids_[static_cast<std::size_t>(end)] == id) ++end;
    if (id < 0) {
      std::fill_n(row.rgb.begin() + 3 * x, 3 * (end - x), std::uint8_t{0});
      std::fill_n(row.weak.begin() + x, end - x, std::uint8_t{1});
    } else if (id < patches) {
      shade_patch(patches_[static_cast<std::size_t>(id)], y, x, end, row);
    } else {
      shade_curved(curved_[static_cast<std::size_t>(id - patches)], y, x, end, row);
    }
    x = end;
  }
}

void Caster::draw_patch(const SeenPatch& seen, int id, int y, float* w) {
  if (y < seen.bounds.y0 || y > seen.bounds.y1) return;
  double low = seen.bounds.x0, high = seen.bounds.x1;
  const auto keep = [&](double at0, double slope) {  // where at0 + slope*x >= 0
    if (slope > 0)
      low = std::max(low, -at0 / slope);
    else if (slope < 0)
      high = std::min(high, -at0 / slope);
    else if (at0 < 0)
      high = -1;
  };
  const double w0 = seen.w.at(0, y), u0 = seen.u.at(0, y), v0 = seen.v.at(0, y);
  const double over_u = seen.patch->size_u + kOverlap, over_v = seen.patch->size_v + kOverlap;
  keep(w0 - 1e-3, seen.w.dx);
  keep(u0 + kOverlap * w0, seen.u.dx + kOverlap * seen.w.dx);
  keep(over_u * w0 - u0, over_u * seen.w.dx - seen.u.dx);
  keep(v0 + kOverlap * w0, seen.v.dx + kOverlap * seen.w.dx);
  keep(over_v * w0 - v0, over_v * seen.w.dx - seen.v.dx);
  if (high < low) return;
  const int x0 = static_cast<int>(std::ceil(low)), x1 = static_cast<int>(high);
  const auto start = static_cast<float>(w0), slope = static_cast<float>(seen.w.dx);
  std::int32_t* ids = ids_.data();
  if (!seen.patch->round) {
    for (int x = x0; x <= x1; ++x) {
      const float here = start + slope * static_cast<float>(x);
      const bool nearer = here > w[x];
      w[x] = nearer ? here : w[x];
      ids[x] = nearer ? id : ids[x];
    }
    return;
  }
  const double r = seen.patch->size_u / 2;
  for (int x = x0; x <= x1; ++x) {
    const float here = start + slope * static_cast<float>(x);
    const double a = seen.u.at(x, y) - r * here, b = seen.v.at(x, y) - r * here, limit = r * here;
    if (here <= w[x] || a * a + b * b > limit * limit) continue;
    w[x] = here;
    ids[x] = id;
  }
}

// |ray z - (its part along a tube's axis) - centre| = radius, solved for 1/z: the larger root is the nearer side.
void Caster::draw_curved(const SeenCurved& seen, int id, int y, float* w) {
  if (y < seen.bounds.y0 || y > seen.bounds.y1) return;
  const bool tube = seen.curved->height > 0;
  const double base = dot(seen.centre, seen.axis), ray_y = (y - k_.cy) / k_.fy;
  for (int x = seen.bounds.x0; x <= seen.bounds.x1; ++x) {
    const Vec3 ray{(x - k_.cx) / k_.fx, ray_y, 1};
    const double up = tube ? dot(ray, seen.axis) : 0;
    const double a = dot(ray, ray) - up * up;
    const double b = dot(ray, seen.centre) - up * base;
    const double root2 = b * b - a * seen.c;
    if (b <= 0 || root2 < 0) continue;
    const double inverse = (b + std::sqrt(root2)) / seen.c;
    const auto here = static_cast<float>(inverse);
    if (here <= w[x] || inverse * kNearest > 1) continue;
    if (tube) {
      const double height = up / inverse - base;
      if (height < 0 || height > seen.curved->height) continue;
    }
    w[x] = here;
    ids_[static_cast<std::size_t>(x)] = id;
  }
}

void Caster::shade_patch(const SeenPatch& seen, int y, int x0, int x1, Row& row) const {
  const Texture& texture = *seen.texture;
  const double scale = 256 / texture.texel_m();
  const auto u0 = static_cast<float>(scale * seen.u.at(0, y)), du = static_cast<float>(scale * seen.u.dx);
  const auto v0 = static_cast<float>(scale * seen.v.at(0, y)), dv = static_cast<float>(scale * seen.v.dx);
  const auto ray_y = static_cast<float>((y - k_.cy) / k_.fy), cx = static_cast<float>(k_.cx);
  const auto per_pixel = static_cast<float>(1 / k_.fx), distance = static_cast<float>(seen.distance_m);
  std::uint8_t* rgb = row.rgb.data() + 3 * x0;
  for (int x = x0; x < x1; ++x, rgb += 3) {
    const auto column = static_cast<float>(x);
    const float w = row.inverse_depth[static_cast<std::size_t>(x)], z = 1.0f / w;
    const int level8 = (3 * coarse_log2_256(z) + seen.level8) / 2;
    const int brightness =
        texture.sample(static_cast<int>((u0 + du * column) * z), static_cast<int>((v0 + dv * column) * z), level8);
    const std::uint32_t colour = texture.colours[static_cast<std::size_t>(brightness)];
    rgb[0] = static_cast<std::uint8_t>(colour);
    rgb[1] = static_cast<std::uint8_t>(colour >> 8);
    rgb[2] = static_cast<std::uint8_t>(colour >> 16);
    const float ray_x = (column - cx) * per_pixel, facing = w * distance;
    const bool grazing = facing * facing < kGrazing2 * (ray_x * ray_x + ray_y * ray_y + 1);
    row.weak[static_cast<std::size_t>(x)] = grazing || (colour & Texture::kDark) != 0 ? 1 : 0;
  }
}

void Caster::shade_curved(const SeenCurved& seen, int y, int x0, int x1, Row& row) const {
  const Texture& texture = *seen.texture;
  const double scale = 256 / texture.texel_m(), r = seen.curved->radius;
  const bool tube = seen.curved->height > 0;
  for (int x = x0; x < x1; ++x) {
    const double z = 1.0 / row.inverse_depth[static_cast<std::size_t>(x)];
    const Vec3 ray = (x - k_.cx) / k_.fx * pose_.right + (y - k_.cy) / k_.fy * pose_.down + pose_.forward;
    const Vec3 p = pose_.position + z * ray - seen.curved->base;
    const Vec3 normal = (1 / r) * Vec3{p.x, p.y, tube ? 0 : p.z};
    const double u = square_angle(p.x, p.y) * 1.5708 * r, v = tube ? p.z : p.z + r;
    const int level8 = coarse_log2_256(static_cast<float>(z)) + seen.level8;
    const int brightness = texture.sample(static_cast<int>(u * scale), static_cast<int>(v * scale), level8);
    const std::uint32_t colour = texture.colours[static_cast<std::size_t>(brightness)];
    const auto light = static_cast<std::uint32_t>(256 * light_on(normal));
    std::uint8_t* rgb = row.rgb.data() + 3 * x;
    for (int channel = 0; channel < 3; ++channel)
      rgb[channel] = static_cast<std::uint8_t>(std::min(255u, ((colour >> (8 * channel)) & 255) * light >> 8));
    const double facing = dot(normal, ray);
    const bool grazing = facing * facing < static_cast<double>(kGrazing2) * dot(ray, ray);
    row.weak[static_cast<std::size_t>(x)] = grazing || (colour & Texture::kDark) != 0 ? 1 : 0;
  }
}

}  // namespace onemap::hal::simulated
