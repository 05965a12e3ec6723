#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "mapping/geometry.hpp"
#include "team/cells.hpp"

namespace onemap::mapping {

// From indices of the global map to continuous indices of a submap's voxels: s = A (g + 0.5) + b, summed as
// A_x (g_x + 0.5), A_y (g_y + 0.5), A_z (g_z + 0.5), b, in this order.
struct SourceGrid {
  std::array<std::array<double, 3>, 3> A{};
  std::array<double, 3> b{};
  std::array<double, 3> steps_x{};  // 1 / A_x, about: steps of g_x for one of s
  Pose T_map_anchor;
  double source_m = 0, global_m = 0;

  SourceGrid(const QuantizedPose& pose, std::int32_t source_um, std::int32_t global_um);
};

// The global map's voxels in reach of a patch, as a box with, for each index on each of its axes, the parts of the sums
// and of the voxel's number that belong to it alone.
struct ReachBox {
  std::array<std::int64_t, 3> low{}, high{};                // both included
  std::array<std::int64_t, 3> first_block{}, blocks{};      // of the global map's blocks around it, and how many
  std::array<std::array<std::vector<double>, 3>, 3> parts;  // [i][j][n]: of s_i, for low[j] + n
  // [j][n], to be added: the block's number among those around (x fastest), times kBlockVoxels, and the voxel's in it.
  std::array<std::vector<std::uint32_t>, 3> numbers;

  void reach(const SourceGrid& grid, const Patch& patch);
  int size(std::size_t axis) const { return static_cast<int>(high[axis] - low[axis]) + 1; }
  bool empty() const { return size(0) <= 0 || size(1) <= 0 || size(2) <= 0; }

 private:
  void fill(const SourceGrid& grid, std::size_t axis);
};

// All of the box's rows, as the hot loop wants them; row by z, see set_z().
cells::Rows rows_of(const SourceGrid& grid, const Patch& patch, const ReachBox& box);
void set_z(const ReachBox& box, std::size_t z, cells::Rows& rows);

}  // namespace onemap::mapping
