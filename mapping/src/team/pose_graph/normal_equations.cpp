#include "normal_equations.hpp"

namespace onemap::mapping {

namespace {

// Conjugate gradients, in products of blocks: what some 30 iterations cost for each block of H. (A product with a
// vector is a sixth of one, and an iteration has two of each block.)
constexpr std::size_t kProductsOfGradients = 20;

bool coupled(const NormalEquations::Pair& edge) {
  return edge.first != NormalEquations::kFixed && edge.second != NormalEquations::kFixed && edge.first != edge.second;
}

BlockMatrix pattern_of(std::size_t variables, const std::vector<NormalEquations::Pair>& edges) {
  std::vector<BlockMatrix::Place> places;
  for (const auto& edge : edges)
    if (coupled(edge)) places.push_back(edge);
  return {variables, std::move(places)};
}

}  // namespace

NormalEquations::NormalEquations(std::size_t variables, const std::vector<Pair>& edges, std::size_t preference)
    : H_(pattern_of(variables, edges)), gradient_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(6 * variables))) {
  for (const auto& edge : edges) {
    Slots slots{.a = edge.first, .b = edge.second};
    if (coupled(edge)) slots.below = H_.find(std::max(slots.a, slots.b), std::min(slots.a, slots.b));
    slots_.push_back(slots);
  }
  const std::size_t gradients = kProductsOfGradients * (H_.diagonal.size() + H_.below.size());
  cholesky_ = BlockCholesky::of(H_, preference * gradients);
  if (!cholesky_) gradients_.emplace(H_);
}

void NormalEquations::clear() {
  H_.set_zero();
  gradient_.setZero();
}

void NormalEquations::add(std::size_t edge, double weight, const Linearised& at, const Matrix6d& information) {
  const Slots& slots = slots_[edge];
  const Matrix6d weighted = weight * information;
  const Matrix6d by_a = weighted.lazyProduct(at.J_a), by_b = weighted.lazyProduct(at.J_b);
  const Vector6d error = weighted * at.error;
  if (slots.a != kFixed) {
    H_.diagonal[slots.a].noalias() += at.J_a.transpose().lazyProduct(by_a);
    gradient_.segment<6>(static_cast<Eigen::Index>(6 * slots.a)).noalias() += at.J_a.transpose() * error;
  }
  if (slots.b != kFixed) {
    H_.diagonal[slots.b].noalias() += at.J_b.transpose().lazyProduct(by_b);
    gradient_.segment<6>(static_cast<Eigen::Index>(6 * slots.b)).noalias() += at.J_b.transpose() * error;
  }
  if (!coupled({slots.a, slots.b})) return;
  if (slots.a < slots.b)
    H_.below[slots.below].noalias() += at.J_b.transpose().lazyProduct(by_a);
  else
    H_.below[slots.below].noalias() += at.J_a.transpose().lazyProduct(by_b);
}

bool NormalEquations::factor(double damping) {
  return cholesky_ ? cholesky_->factor(H_, damping) : gradients_->prepare(H_, damping);
}

NormalEquations::Step NormalEquations::step() const {
  if (cholesky_) return {cholesky_->solve(-gradient_)};
  ConjugateGradients::Answer answer = gradients_->solve(-gradient_);
  return {std::move(answer.x), answer.converged};
}

std::optional<Matrix6d> NormalEquations::covariance(const Pair& edge, const Linearised& at) const {
  if (!cholesky_) return std::nullopt;
  std::vector<BlockCholesky::Row> rows;
  const auto add = [&](std::size_t row,
                       const Matrix6d& J) {  // a block as it is made is one too many for GCC's sanitizers
    const Matrix6d block = J.transpose();
    if (row != kFixed) rows.push_back({row, block});
  };
  add(edge.first, at.J_a);
  add(edge.second, at.J_b);
  return cholesky_->inverse_between(rows);
}

}  // namespace onemap::mapping
