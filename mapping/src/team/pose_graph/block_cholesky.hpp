#pragma once
#include <optional>

#include "block_matrix.hpp"

namespace onemap::mapping {

// H = P L L^T P^T for matrices with blocks in the same places: the order of elimination (approximate minimum degree of
// the blocks) and where L has blocks is found once.
class BlockCholesky {
 public:
  // Nothing when one factorisation would cost more than so many multiplications of blocks.
  static std::optional<BlockCholesky> of(const BlockMatrix& pattern, std::size_t most_products);

  std::size_t products() const { return products_; }
  // With the diagonal multiplied by 1 + damping. False: not positive definite.
  bool factor(const BlockMatrix& H, double damping);
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const;
  // J^T H^-1 J of a J with one or two blocks that are not zero, in these rows.
  struct Row {
    std::size_t row;
    Matrix6d block;
  };
  Matrix6d inverse_between(const std::vector<Row>& J) const;

 private:
  BlockCholesky() = default;
  bool eliminate(std::size_t column);
  void subtract(std::size_t column, std::size_t from);

  std::size_t products_ = 0;
  std::vector<std::size_t> place_;        // of each row of H in the order of elimination
  std::vector<Matrix6d> diagonal_;        // of L, lower triangles
  std::vector<std::size_t> first_, row_;  // as in BlockMatrix
  std::vector<Matrix6d> below_;
  std::vector<std::size_t> from_;  // of each block of H in `below`: where it goes in below_
  std::vector<bool> mirrored_;     // and whether it is its mirror image that goes there
};

}  // namespace onemap::mapping
