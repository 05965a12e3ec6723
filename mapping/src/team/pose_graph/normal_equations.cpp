#include "normal_equations.hpp"

#include <algorithm>
#include <set>

namespace onemap::mapping {

namespace {

// The blocks below the diagonal of each column of blocks, ascending.
std::vector<std::vector<std::size_t>> blocks_below(std::size_t variables,
                                                   const std::vector<NormalEquations::Pair>& edges) {
  std::vector<std::set<std::size_t>> below(variables);
  for (const auto& [a, b] : edges)
    if (a != NormalEquations::kFixed && b != NormalEquations::kFixed && a != b)
      below[std::min(a, b)].insert(std::max(a, b));
  std::vector<std::vector<std::size_t>> out;
  out.reserve(below.size());
  for (const auto& rows : below) out.emplace_back(rows.begin(), rows.end());
  return out;
}

// In column c of a block column, after the 6 - c of the diagonal block, come six of each block below it.
Eigen::SparseMatrix<double> zeros(const std::vector<std::vector<std::size_t>>& below) {
  const auto size = static_cast<Eigen::Index>(6 * below.size());
  Eigen::SparseMatrix<double> H(size, size);
  for (std::size_t j = 0; j < below.size(); ++j)
    for (std::size_t c = 0; c < 6; ++c) {
      const auto column = static_cast<Eigen::Index>(6 * j + c);
      H.startVec(column);
      for (std::size_t r = c; r < 6; ++r) H.insertBack(static_cast<Eigen::Index>(6 * j + r), column) = 0;
      for (std::size_t i : below[j])
        for (std::size_t r = 0; r < 6; ++r) H.insertBack(static_cast<Eigen::Index>(6 * i + r), column) = 0;
    }
  H.finalize();
  return H;
}

}  // namespace

NormalEquations::NormalEquations(std::size_t variables, const std::vector<Pair>& edges)
    : gradient_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(6 * variables))) {
  const auto below = blocks_below(variables, edges);
  for (const auto& [a, b] : edges) {
    Slots slots{.a = a, .b = b, .swapped = a > b};
    if (a != kFixed && b != kFixed && a != b) {
      const auto& rows = below[std::min(a, b)];
      slots.lower = static_cast<std::size_t>(std::lower_bound(rows.begin(), rows.end(), std::max(a, b)) - rows.begin());
    }
    slots_.push_back(slots);
  }
  H_ = zeros(below);
  damped_ = H_;
  ldlt_.analyzePattern(H_);
}

void NormalEquations::clear() {
  H_.coeffs().setZero();
  gradient_.setZero();
}

void NormalEquations::add_diagonal(std::size_t variable, const Matrix6d& block) {
  for (std::size_t c = 0; c < 6; ++c) {
    double* at = H_.valuePtr() + H_.outerIndexPtr()[6 * variable + c];
    for (std::size_t r = c; r < 6; ++r) at[r - c] += block(static_cast<int>(r), static_cast<int>(c));
  }
}

void NormalEquations::add_lower(const Slots& slots, const Matrix6d& b_by_a) {
  const std::size_t column = std::min(slots.a, slots.b);
  for (std::size_t c = 0; c < 6; ++c) {
    double* at = H_.valuePtr() + H_.outerIndexPtr()[6 * column + c] + (6 - c) + 6 * slots.lower;
    for (std::size_t r = 0; r < 6; ++r) {
      const auto row = static_cast<int>(r), col = static_cast<int>(c);
      at[r] += slots.swapped ? b_by_a(col, row) : b_by_a(row, col);
    }
  }
}

void NormalEquations::add(std::size_t edge, double weight, const Linearised& at, const Matrix6d& information) {
  const Slots& slots = slots_[edge];
  const Matrix6d weighted = weight * information;
  const Matrix6d by_a = weighted * at.J_a, by_b = weighted * at.J_b;
  const Vector6d error = weighted * at.error;
  if (slots.a != kFixed) {
    add_diagonal(slots.a, at.J_a.transpose() * by_a);
    gradient_.segment<6>(static_cast<Eigen::Index>(6 * slots.a)) += at.J_a.transpose() * error;
  }
  if (slots.b != kFixed) {
    add_diagonal(slots.b, at.J_b.transpose() * by_b);
    gradient_.segment<6>(static_cast<Eigen::Index>(6 * slots.b)) += at.J_b.transpose() * error;
  }
  if (slots.a != kFixed && slots.b != kFixed) add_lower(slots, at.J_b.transpose() * by_a);
}

bool NormalEquations::factor(double damping) {
  damped_.coeffs() = H_.coeffs();
  for (Eigen::Index i = 0; i < damped_.cols(); ++i) damped_.valuePtr()[damped_.outerIndexPtr()[i]] *= 1 + damping;
  ldlt_.factorize(damped_);
  return ldlt_.info() == Eigen::Success && (ldlt_.vectorD().array() > 0).all();
}

Matrix6d NormalEquations::covariance(const Pair& edge, const Linearised& at) const {
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(gradient_.size(), 6);
  if (edge.first != kFixed) J.middleRows<6>(static_cast<Eigen::Index>(6 * edge.first)) += at.J_a.transpose();
  if (edge.second != kFixed) J.middleRows<6>(static_cast<Eigen::Index>(6 * edge.second)) += at.J_b.transpose();
  return J.transpose() * ldlt_.solve(J);
}

}  // namespace onemap::mapping
