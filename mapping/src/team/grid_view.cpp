#include "team/grid_view.hpp"

#include <algorithm>
#include <cmath>

#include "hal/depth_noise.hpp"

namespace onemap::mapping {
namespace {

constexpr float kNearest_m = 0.1f;  // nearer cells fill the whole view
constexpr hal::DepthNoise kNoise;   // records do not say whose depth it is

}  // namespace

GridView::GridView(const DepthGrid& grid, const Pose& T, const FreeSpaceConfig& config)
    : T_map_camera(T), width(grid.width), height(grid.height) {
  fx = grid.fx_fy_cx_cy[0] / 1024.0, fy = grid.fx_fy_cx_cy[1] / 1024.0;
  cx = grid.fx_fy_cx_cy[2] / 1024.0, cy = grid.fx_fy_cx_cy[3] / 1024.0;
  through_m.reserve(grid.inverse_depth.size());
  for (const std::uint16_t q : grid.inverse_depth) {
    const double z = grid_depth_m(q);
    const double before = z - kHalfDiagonal * config.cell_m - 3 * kNoise.sigma_m(z);
    const double through = z > 0 ? std::min(std::max(before, 0.0), config.reach_m) : 0;
    through_m.push_back(static_cast<float>(through));
    farthest_m = std::max(farthest_m, through);
  }
}

std::array<Vector3d, 5> GridView::corners() const {
  std::array<Vector3d, 5> out{T_map_camera.t};
  for (int i = 0; i < 4; ++i) {
    const double u = (i & 1) != 0 ? width - 0.5 : -0.5, v = (i & 2) != 0 ? height - 0.5 : -0.5;
    out[static_cast<std::size_t>(i) + 1] = T_map_camera * (farthest_m * Vector3d((u - cx) / fx, (v - cy) / fy, 1));
  }
  return out;
}

bool GridView::sees(const Vector3d& p, double radius) const {
  if (p.z() + radius < static_cast<double>(kNearest_m) || p.z() - radius > farthest_m) return false;
  const auto beyond = [&](double along, double focal, double edge) {  // of the plane along * focal = edge * z
    return along * focal - edge * p.z() > radius * std::sqrt(focal * focal + edge * edge);
  };
  return !beyond(p.x(), fx, width - 0.5 - cx) && !beyond(-p.x(), fx, cx + 0.5) &&
         !beyond(p.y(), fy, height - 0.5 - cy) && !beyond(-p.y(), fy, cy + 0.5);
}

// Two loops, so that the first is arithmetic alone and is vectorised.
unsigned GridView::row_through(const Eigen::Vector3f& p0, const Eigen::Vector3f& step) const {
  std::array<float, kBlockSide> z{}, u{}, v{};
  const auto x_px = static_cast<float>(fx), y_px = static_cast<float>(fy);
  const auto u0 = static_cast<float>(cx + 0.5), v0 = static_cast<float>(cy + 0.5);
  for (std::size_t i = 0; i < kBlockSide; ++i) {
    const auto k = static_cast<float>(i);
    z[i] = p0.z() + k * step.z();
    const float inverse = 1 / std::max(z[i], kNearest_m);
    u[i] = x_px * (p0.x() + k * step.x()) * inverse + u0;
    v[i] = y_px * (p0.y() + k * step.y()) * inverse + v0;
  }
  const auto w = static_cast<float>(width), h = static_cast<float>(height);
  unsigned bits = 0;
  for (std::size_t i = 0; i < kBlockSide; ++i) {
    if (!(z[i] >= kNearest_m && u[i] >= 0 && u[i] < w && v[i] >= 0 && v[i] < h)) continue;
    const int pixel = static_cast<int>(v[i]) * width + static_cast<int>(u[i]);
    bits |= z[i] < through_m[static_cast<std::size_t>(pixel)] ? 1u << i : 0u;
  }
  return bits;
}

}  // namespace onemap::mapping
