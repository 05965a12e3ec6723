#pragma once
#include <array>
#include <vector>

#include "mapping/geometry.hpp"
#include "mapping/local/block_key.hpp"
#include "mapping/records/depth_grid.hpp"
#include "mapping/team/free_space.hpp"

namespace onemap::mapping {

inline constexpr double kHalfDiagonal = 0.8660254;  // of a cube, against its side

// A keyframe's view into free space: its pinhole with, for each pixel, the depth up to which it sees through.
struct GridView {
  Pose T_map_camera;
  int width = 0, height = 0;
  double fx = 1, fy = 1, cx = 0, cy = 0;
  std::vector<float> through_m;  // 0: not at all
  double farthest_m = 0;         // of these

  GridView(const DepthGrid& grid, const Pose& T, const FreeSpaceConfig& config);

  // The corners of what is seen, in the map's frame: the camera and the far rectangle.
  std::array<Vector3d, 5> corners() const;
  // Whether a ball about p (camera's frame) may reach into what is seen.
  bool sees(const Vector3d& p, double radius) const;
  // Of eight cells in a row, p0 + i * step (camera's frame): bit i for those that are seen through.
  unsigned row_through(const Eigen::Vector3f& p0, const Eigen::Vector3f& step) const;
};

}  // namespace onemap::mapping
