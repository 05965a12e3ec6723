#pragma once
#include <cstddef>
#include <utility>
#include <vector>

#include "mapping/team/pose_graph_input.hpp"

namespace onemap::mapping {

// A symmetric matrix of 6 x 6 blocks: those on the diagonal, and of those below it the ones that may not be zero.
struct BlockMatrix {
  using Place = std::pair<std::size_t, std::size_t>;

  // With a block, all zero, for each of the places (the same as their mirror images; twice is once).
  BlockMatrix(std::size_t size, std::vector<Place> places);

  std::size_t size() const { return diagonal.size(); }
  std::size_t find(std::size_t row, std::size_t column) const;  // in `below`; it must be there, row > column
  void set_zero();
  Eigen::VectorXd times(const Eigen::VectorXd& x) const;

  std::vector<Matrix6d> diagonal;
  std::vector<std::size_t> first;  // of each column in `below`, and the end
  std::vector<std::size_t> row;    // of each in `below`, ascending in a column
  std::vector<Matrix6d> below;
};

// The row at which a block begins.
inline Eigen::Index row_of(std::size_t block) { return static_cast<Eigen::Index>(6 * block); }

}  // namespace onemap::mapping
