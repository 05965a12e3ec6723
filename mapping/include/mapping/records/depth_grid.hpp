#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace onemap::mapping {

// A depth image on an ideal pinhole grid (see OrganizedCloud), coarse: for ICP between robots and for free space. Depth
// is inverse, in steps of 0.002 / m: at most 1 mm x z^2 off (9 mm at 3 m), below what a structured-light sensor
// resolves.
struct DepthGrid {
  static constexpr int kMostWidth = 160, kMostHeight = 120;
  static constexpr double kStepsPerInverseMetre = 500;
  static constexpr std::uint16_t kFarthest = 62, kNearest = 10000;  // 8.06 m, 5 cm

  std::uint16_t width = 0, height = 0;  // at most 160 x 120; both 0: no grid, but still a pinhole
  std::array<std::int32_t, 4> fx_fy_cx_cy{1 << 17, 1 << 17, 0, 0};  // pixels of this grid, units of 1/1024
  std::vector<std::uint16_t> inverse_depth;  // steps, kFarthest to kNearest; 0 = none; row by row
};

// Metres, 0 = none, and back; what is farther or nearer than a grid can say becomes none.
inline double grid_depth_m(std::uint16_t inverse_depth) {
  return inverse_depth == 0 ? 0 : DepthGrid::kStepsPerInverseMetre / inverse_depth;
}
inline std::uint16_t grid_inverse_depth(double z_m) {
  const double steps = z_m > 0 ? DepthGrid::kStepsPerInverseMetre / z_m : 0;
  const bool fits = steps >= DepthGrid::kFarthest - 0.5 && steps < DepthGrid::kNearest + 0.5;
  return fits ? static_cast<std::uint16_t>(std::lround(steps)) : std::uint16_t{0};
}

}  // namespace onemap::mapping
