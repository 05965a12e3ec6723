#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "mapping/geometry.hpp"

namespace onemap::mapping {

// Voxel-grid downsampling with one leaf size in all directions (the paper, figure 7): every occupied voxel gives the mean
// of its points. Output sorted by voxel (x, then y, then z), so it does not depend on the order of the input beyond the rounding of
// sums, which are taken in input order. Memory is taken in the constructor.
class VoxelGrid {
 public:
  VoxelGrid(float leaf_m, std::size_t max_points);
  // Writes at most out.size() points; returns how many. in.size() <= max_points; points within +-2^20 leaves of 0.
  std::size_t downsample(std::span<const Vector3f> in, std::span<Vector3f> out);
  std::size_t bytes() const;

 private:
  struct Cell;
  float leaf_m_;
  std::size_t max_points_;
  std::vector<std::uint64_t> keys_, scratch_;
};

}  // namespace onemap::mapping
