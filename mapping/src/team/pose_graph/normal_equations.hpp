#pragma once
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "graph_edge.hpp"

namespace onemap::mapping {

// H x = -g of Gauss-Newton over poses, in blocks of 6 x 6. What is where, and the order of elimination (approximate
// minimum degree), is found once for the pairs that may ever be coupled.
class NormalEquations {
 public:
  static constexpr std::size_t kFixed = static_cast<std::size_t>(-1);  // a pose that is no variable
  using Pair = std::pair<std::size_t, std::size_t>;                    // variables of an edge's a and b, or kFixed

  NormalEquations(std::size_t variables, const std::vector<Pair>& edges);

  void clear();
  void add(std::size_t edge, double weight, const Linearised& at, const Matrix6d& information);
  // Factors H with its diagonal multiplied by 1 + damping. False: not positive definite.
  bool factor(double damping);
  Eigen::VectorXd step() const { return ldlt_.solve(-gradient_); }
  // The covariance of the error of an edge by everything else: J H^-1 J^T, of the factor as it is.
  Matrix6d covariance(const Pair& edge, const Linearised& at) const;

 private:
  struct Slots {
    std::size_t a, b;       // variables
    std::size_t lower = 0;  // which of the blocks below the diagonal in its column
    bool swapped = false;   // a is the later one, so its row
  };
  void add_diagonal(std::size_t variable, const Matrix6d& block);
  void add_lower(const Slots& slots, const Matrix6d& b_by_a);

  std::vector<Slots> slots_;
  Eigen::SparseMatrix<double> H_, damped_;  // lower triangle
  Eigen::VectorXd gradient_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::AMDOrdering<int>> ldlt_;
};

}  // namespace onemap::mapping
