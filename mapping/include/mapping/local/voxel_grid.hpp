#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "mapping/geometry.hpp"

namespace onemap::mapping {

// Voxel-grid downsampling with one leaf size in all directions (the paper, figure 7): every occupied voxel gives the
// mean of its points. Output sorted by voxel (x, then y, then z), so it does not depend on the order of the input
// beyond the rounding of sums, which are taken in input order. Memory is taken in the constructor.
class VoxelGrid {
 public:
  VoxelGrid(float leaf_m, std::size_t max_points);
  // Writes at most out.size() points; returns how many. in.size() <= max_points. Points that are not finite or farther
  // than 2^20 leaves from 0 are left out.
  std::size_t downsample(std::span<const Vector3f> in, std::span<Vector3f> out);
  std::size_t bytes() const;

 private:
  struct Cell {
    std::uint64_t key = 0;
    double x = 0, y = 0, z = 0;  // sums
    std::uint32_t count = 0, slot = 0;
  };
  struct Order {
    std::uint64_t key;
    std::uint32_t cell;
  };
  Cell& cell_of(std::uint64_t key);

  float leaf_m_;
  [[maybe_unused]] std::size_t max_points_;  // only asserted
  std::size_t used_ = 0;                     // cells of the current call
  std::vector<Cell> cells_;
  std::vector<Order> order_;
  std::vector<std::uint32_t> slots_;
};

}  // namespace onemap::mapping
