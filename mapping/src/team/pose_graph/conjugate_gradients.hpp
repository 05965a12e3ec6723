#pragma once
#include "block_matrix.hpp"

namespace onemap::mapping {

// H x = b by conjugate gradients, for graphs that are so interwoven that a factor would have little but fill-in. They
// are also the ones on which few iterations do: what couples next neighbours, odometry above all, is solved exactly in
// each (a block-tridiagonal preconditioner), and many links leave no soft modes.
class ConjugateGradients {
 public:
  explicit ConjugateGradients(const BlockMatrix& pattern);

  // With the diagonal multiplied by 1 + damping. False: not positive definite.
  bool prepare(const BlockMatrix& H, double damping);
  struct Answer {
    Eigen::VectorXd x;
    bool converged = false;  // the residual is small beside b, both as the preconditioner weighs them
  };
  Answer solve(const Eigen::VectorXd& b) const;

 private:
  Eigen::VectorXd precondition(const Eigen::VectorXd& r) const;

  BlockMatrix damped_;
  std::vector<std::size_t> next_;  // of each row, its block with the next one in damped_.below; kNone: not coupled
  std::vector<Matrix6d> inverse_;  // of the pivots
  std::vector<Matrix6d> carry_;    // what of each row goes into the next one
};

}  // namespace onemap::mapping
