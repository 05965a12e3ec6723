#include "mapping/local/organized_cloud.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "floor_int.hpp"
#include "hal/lens.hpp"
#include "mapping/local/depth_range.hpp"

namespace onemap::mapping {

namespace {

// The block of pixels that a cell reads and the ray through the block's middle.
void look_up_cells(const hal::Intrinsics& k, OrganizedCloud& out) {
  const int block_u = std::max(1, k.width / out.width), block_v = std::max(1, k.height / out.height);
  out.sampling.resize(out.points.size());
  std::size_t i = 0;
  for (int v = 0; v < out.height; ++v) {
    for (int u = 0; u < out.width; ++u, ++i) {
      const hal::Point2 px = hal::pixel_of(k, {(u - out.cx) / out.fx, (v - out.cy) / out.fy});
      const int u0 = floor_int<int>(px.x - 0.5 * (block_u - 1) + 0.5);
      const int v0 = floor_int<int>(px.y - 0.5 * (block_v - 1) + 0.5);
      auto& cell = out.sampling[i];
      const bool inside = u0 >= 0 && v0 >= 0 && u0 + block_u <= k.width && v0 + block_v <= k.height;
      cell.first_pixel = inside ? v0 * k.width + u0 : -1;
      const hal::Point2 middle = hal::ray_of(k, {u0 + 0.5 * (block_u - 1), v0 + 0.5 * (block_v - 1)});
      cell.x = static_cast<float>(middle.x);
      cell.y = static_cast<float>(middle.y);
    }
  }
}

void set_grid(const hal::Intrinsics& k, int width, int height, OrganizedCloud& out) {
  const double su = static_cast<double>(width) / k.width, sv = static_cast<double>(height) / k.height;
  out.width = width;
  out.height = height;
  out.fx = static_cast<float>(su * k.fx);
  out.fy = static_cast<float>(sv * k.fy);
  out.cx = static_cast<float>(su * (k.cx + 0.5) - 0.5);  // pixel centres are at integers
  out.cy = static_cast<float>(sv * (k.cy + 0.5) - 0.5);
  const std::size_t cells = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  out.points.resize(cells);
  out.normals.resize(cells);
  out.inverse_depth.resize(cells);
  look_up_cells(k, out);
  out.camera = k;
}

// How far depths of one surface differ within a few pixels: slope and noise.
float same_surface_m(const hal::DepthNoise& noise, float z_m) { return 0.01f * z_m + 4 * noise.sigma_m(z_m); }

// Mean depth of the block's pixels that lie on the surface of the block's middle (or first valid) pixel; 0: none.
float mean_depth(const std::uint16_t* block, int row_pixels, int block_u, int block_v, float metres,
                 const hal::DepthNoise& noise) {
  int reference = block[(block_v / 2) * row_pixels + block_u / 2];
  for (int v = 0; v < block_v && reference == 0; ++v) {
    for (int u = 0; u < block_u && reference == 0; ++u) reference = block[v * row_pixels + u];
  }
  const float z = static_cast<float>(reference) * metres;
  if (!(z >= kMinDepth_m && z <= kMaxDepth_m)) return 0;
  const int gate = static_cast<int>(same_surface_m(noise, z) / metres);
  int sum = 0, count = 0;
  for (int v = 0; v < block_v; ++v) {
    for (int u = 0; u < block_u; ++u) {
      const int d = block[v * row_pixels + u];
      const int use = (d - reference <= gate) & (reference - d <= gate) & (d != 0);
      sum += use ? d : 0;
      count += use;
    }
  }
  return static_cast<float>(sum) / static_cast<float>(count) * metres;
}

// On a plane n.p = h the inverse depth is linear in the ray: 1/z = (n.(x, y, 1)) / h, and the noise of a
// structured-light sensor is even in 1/z. So the normal is a least-squares line fit of 1/z over the window, using the
// cells of the same surface only.
Vector3f normal_at(const OrganizedCloud& cloud, int u, int v) {
  constexpr int kRadius = 2;
  constexpr int kMinCells = 10;
  const int index = v * cloud.width + u;
  const float* q = cloud.inverse_depth.data() + index;
  const OrganizedCloud::Sampling* at = cloud.sampling.data() + index;
  if (*q == 0) return Vector3f::Zero();
  const float z = 1 / *q;
  const float gate = 3 * same_surface_m(cloud.noise, z) * *q * *q;  // as a difference of 1/z
  float n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0, sq = 0, sxq = 0, syq = 0;
  for (int j = std::max(-kRadius, -v); j <= std::min(kRadius, cloud.height - 1 - v); ++j) {
    for (int i = std::max(-kRadius, -u); i <= std::min(kRadius, cloud.width - 1 - u); ++i) {
      const int k = j * cloud.width + i;
      const float d = q[k] - *q;
      if (!(std::abs(d) <= gate)) continue;
      const float x = at[k].x - at->x, y = at[k].y - at->y;
      n += 1, sx += x, sy += y, sxx += x * x, sxy += x * y, syy += y * y;
      sq += d, sxq += x * d, syq += y * d;
    }
  }
  if (n < kMinCells) return Vector3f::Zero();
  const float cxx = sxx - sx * sx / n, cxy = sxy - sx * sy / n, cyy = syy - sy * sy / n;
  const float cxq = sxq - sx * sq / n, cyq = syq - sy * sq / n;
  const float det = cxx * cyy - cxy * cxy, det_in_cells = det * cloud.fx * cloud.fx * cloud.fy * cloud.fy;
  if (!(det_in_cells > 0.05f * n * n)) return Vector3f::Zero();
  const float a = (cxq * cyy - cyq * cxy) / det, b = (cyq * cxx - cxq * cxy) / det;
  const float middle = *q + (sq - a * sx - b * sy) / n;
  const Vector3f away(a, b, middle - a * at->x - b * at->y);
  const float norm = std::sqrt(away.x() * away.x() + away.y() * away.y() + away.z() * away.z());
  return -away / norm;
}

void fit_normals(OrganizedCloud& cloud) {
  std::size_t i = 0;
  for (int v = 0; v < cloud.height; ++v) {
    for (int u = 0; u < cloud.width; ++u, ++i) cloud.normals[i] = normal_at(cloud, u, v);
  }
}

// The depth that each cell's ray meets from where the camera came to, by looking up where that surface was before.
// Edges that a glance behind would be needed for are left out.
void move_camera(const Pose& T_after_before, OrganizedCloud& cloud) {
  constexpr int kRounds = 2;
  const Eigen::Matrix3f R = T_after_before.R.cast<float>();
  const Vector3f t = T_after_before.t.cast<float>();
  const auto after = [&](const Vector3f& p) -> Vector3f { return R * p + t; };
  const auto before = [&](const Vector3f& p) -> Vector3f { return R.transpose() * (p - t); };
  const auto looked_up = [&](const Vector3f& p) {  // z of the surface that this point is on; 0: nothing is there
    const Vector3f q = before(p);
    if (!(q.z() >= kMinDepth_m)) return 0.0f;
    const int u = floor_int<int>(q.x() / q.z() * cloud.fx + cloud.cx + 0.5f);
    const int v = floor_int<int>(q.y() / q.z() * cloud.fy + cloud.cy + 0.5f);
    if (u < 0 || v < 0 || u >= cloud.width || v >= cloud.height) return 0.0f;
    const Vector3f& there = cloud.points[cloud.index(u, v)];
    return there.z() > 0 ? after(there).z() : 0.0f;
  };
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const auto& cell = cloud.sampling[i];
    float z = cloud.points[i].z(), last = z;
    for (int round = 0; round < kRounds && z > 0; ++round)
      last = std::exchange(z, looked_up({cell.x * z, cell.y * z, z}));
    const bool on_one_surface =
        z >= kMinDepth_m && z <= kMaxDepth_m && std::abs(z - last) <= 3 * same_surface_m(cloud.noise, z);
    cloud.inverse_depth[i] = on_one_surface ? 1 / z : 0;
  }
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const auto& cell = cloud.sampling[i];
    const float z = cloud.inverse_depth[i] > 0 ? 1 / cloud.inverse_depth[i] : 0;
    cloud.points[i] = {cell.x * z, cell.y * z, z};
  }
}

}  // namespace

void organize(std::span<const std::uint16_t> depth, const hal::Intrinsics& intrinsics, int width, int height,
              OrganizedCloud& out, const std::optional<Pose>& T_colour_depth) {
  if (out.width != width || out.height != height || out.camera != intrinsics) {
    set_grid(intrinsics, width, height, out);
  }
  const float metres = static_cast<float>(1.0 / intrinsics.depth_scale);
  const int block_u = std::max(1, intrinsics.width / width), block_v = std::max(1, intrinsics.height / height);
  for (std::size_t i = 0; i < out.points.size(); ++i) {
    const auto& cell = out.sampling[i];
    const float z = cell.first_pixel < 0 ? 0
                                         : mean_depth(depth.data() + cell.first_pixel, intrinsics.width, block_u,
                                                      block_v, metres, out.noise);
    out.points[i] = {cell.x * z, cell.y * z, z};
    out.inverse_depth[i] = z > 0 ? 1 / z : 0;
  }
  if (T_colour_depth) move_camera(*T_colour_depth, out);
  fit_normals(out);
}

void organize_grid(std::span<const float> depth_m, Normals normals, OrganizedCloud& out) {
  out.points.resize(depth_m.size());
  out.sampling.resize(depth_m.size());
  out.inverse_depth.resize(depth_m.size());
  std::size_t i = 0;
  for (int v = 0; v < out.height; ++v) {
    for (int u = 0; u < out.width; ++u, ++i) {
      const float z = depth_m[i];
      auto& cell = out.sampling[i];
      cell.x = (static_cast<float>(u) - out.cx) / out.fx;
      cell.y = (static_cast<float>(v) - out.cy) / out.fy;
      out.points[i] = {cell.x * z, cell.y * z, z};
      out.inverse_depth[i] = z > 0 ? 1 / z : 0;
    }
  }
  out.normals.assign(normals == Normals::fitted ? depth_m.size() : 0, Vector3f::Zero());
  if (normals == Normals::fitted) fit_normals(out);
}

}  // namespace onemap::mapping
