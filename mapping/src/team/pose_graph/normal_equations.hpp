#pragma once
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "block_cholesky.hpp"
#include "conjugate_gradients.hpp"
#include "graph_edge.hpp"

namespace onemap::mapping {

// H x = -g of Gauss-Newton over poses, in blocks of 6 x 6. What is where, and how it is solved, is found once for the
// pairs that may ever be coupled: by a factor, or, where that has too much fill-in, by conjugate gradients.
class NormalEquations {
 public:
  static constexpr std::size_t kFixed = static_cast<std::size_t>(-1);  // a pose that is no variable
  using Pair = std::pair<std::size_t, std::size_t>;                    // variables of an edge's a and b, or kFixed

  // Prefers a factor up to so many times what conjugate gradients would cost: 1 is the cheapest, more is for who needs
  // covariances.
  NormalEquations(std::size_t variables, const std::vector<Pair>& edges, std::size_t preference);

  void clear();
  void add(std::size_t edge, double weight, const Linearised& at, const Matrix6d& information);
  // Takes H with its diagonal multiplied by 1 + damping. False: not positive definite.
  bool factor(double damping);
  struct Step {
    Eigen::VectorXd by;
    bool exact = true;  // as far as anybody asks
  };
  Step step() const;
  // The covariance of the error of an edge by everything else: J H^-1 J^T, of the factor as it is. Nothing without one.
  std::optional<Matrix6d> covariance(const Pair& edge, const Linearised& at) const;

 private:
  struct Slots {
    std::size_t a, b;       // variables
    std::size_t below = 0;  // their block
  };

  std::vector<Slots> slots_;
  BlockMatrix H_;
  Eigen::VectorXd gradient_;
  std::optional<BlockCholesky> cholesky_;
  std::optional<ConjugateGradients> gradients_;  // without a factor
};

}  // namespace onemap::mapping
