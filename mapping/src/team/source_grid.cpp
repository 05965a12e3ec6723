#include "team/source_grid.hpp"

#include <algorithm>
#include <cmath>

#include "floor_int.hpp"

namespace onemap::mapping {
namespace {

std::array<std::int64_t, 3> first_voxel(const BlockKey& key) {
  return {std::int64_t{kBlockSide} * key.x, std::int64_t{kBlockSide} * key.y, std::int64_t{kBlockSide} * key.z};
}

}  // namespace

SourceGrid::SourceGrid(const QuantizedPose& pose, std::int32_t source_um, std::int32_t global_um)
    : T_map_anchor(from_quantized(pose)), source_m(source_um * 1e-6), global_m(global_um * 1e-6) {
  const double scale = static_cast<double>(global_um) / source_um;
  for (std::size_t i = 0; i < 3; ++i) {
    double along = 0;  // the anchor's axis i over the translation, in units of 10 micrometres
    for (std::size_t j = 0; j < 3; ++j) {
      const double r = T_map_anchor.R(static_cast<int>(j), static_cast<int>(i));
      A[i][j] = r * scale;
      along = along + r * pose.t_10um[j];
    }
    b[i] = -(along * 10 / source_um) - 0.5;
    steps_x[i] = 1 / std::copysign(std::max(std::abs(A[i][0]), 1e-9), A[i][0]);
  }
}

void ReachBox::reach(const SourceGrid& grid, const Patch& patch) {
  const Pose& T = grid.T_map_anchor;
  const auto origin = first_voxel(patch.key());
  for (std::size_t i = 0; i < 3; ++i) {
    double least = T.t[static_cast<int>(i)], most = least;
    for (std::size_t j = 0; j < 3; ++j) {
      const double r = T.R(static_cast<int>(i), static_cast<int>(j)) * grid.source_m;
      const double from = r * (static_cast<double>(origin[j] + patch.low()[j]) + 0.5);
      const double to = r * (static_cast<double>(origin[j] + patch.high()[j]) + 1.5);
      least += std::min(from, to);
      most += std::max(from, to);
    }
    // Centres are half a voxel on; a tenth of one is more than all rounding.
    low[i] = floor_int<std::int64_t>(least / grid.global_m - 0.6) + 1;
    high[i] = floor_int<std::int64_t>(most / grid.global_m - 0.4);
  }
  if (empty()) return;
  for (std::size_t i = 0; i < 3; ++i) {
    first_block[i] = low[i] >> 3;
    blocks[i] = (high[i] >> 3) - first_block[i] + 1;
  }
  for (std::size_t i = 0; i < 3; ++i) fill(grid, i);
}

void ReachBox::fill(const SourceGrid& grid, std::size_t axis) {
  const auto count = static_cast<std::size_t>(size(axis)) + cells::kStride;  // rows are worked on beyond their end
  std::int64_t voxel = 1, block = kBlockVoxels;
  for (std::size_t i = 0; i < axis; ++i) {
    voxel *= kBlockSide;
    block *= blocks[i];
  }
  auto& number = numbers[axis];
  if (number.size() < count) number.resize(count);
  for (std::size_t n = 0; n < count; ++n) {
    const std::int64_t index = low[axis] + static_cast<std::int64_t>(n);
    number[n] =
        static_cast<std::uint32_t>(((index >> 3) - first_block[axis]) * block + (index & (kBlockSide - 1)) * voxel);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    auto& part = parts[i][axis];
    if (part.size() < count) part.resize(count);
    for (std::size_t n = 0; n < count; ++n)
      part[n] = grid.A[i][axis] * (static_cast<double>(low[axis] + static_cast<std::int64_t>(n)) + 0.5);
  }
}

cells::Rows rows_of(const SourceGrid& grid, const Patch& patch, const ReachBox& box) {
  cells::Rows out;
  const auto origin = first_voxel(patch.key());
  for (std::size_t i = 0; i < 3; ++i) {
    out.x[i] = box.parts[i][0].data();
    out.y[i] = box.parts[i][1].data();
    out.offset[i] = grid.b[i];
    out.from[i] = static_cast<double>(origin[i] + patch.low()[i]) - 0.01;
    out.to[i] = static_cast<double>(origin[i] + patch.high()[i] + 1) + 0.01;
    out.origin[i] = static_cast<double>(cells::kFraction * origin[i]);
  }
  out.steps = grid.steps_x;
  out.columns = box.size(0);
  out.rows = box.size(1);
  out.number_x = box.numbers[0].data();
  out.number_y = box.numbers[1].data();
  out.whole = patch.whole_rows();
  return out;
}

void set_z(const ReachBox& box, std::size_t z, cells::Rows& rows) {
  for (std::size_t i = 0; i < 3; ++i) rows.z[i] = box.parts[i][2][z];
  rows.number_z = box.numbers[2][z];
}

}  // namespace onemap::mapping
