#include "conjugate_gradients.hpp"

#include <Eigen/Cholesky>

namespace onemap::mapping {

namespace {

constexpr std::size_t kNone = static_cast<std::size_t>(-1);
constexpr std::size_t kMostIterations = 400;
constexpr double kResidual = 1e-3;  // beside the first one: Gauss-Newton corrects what is left in its next step

}  // namespace

ConjugateGradients::ConjugateGradients(const BlockMatrix& pattern)
    : damped_(pattern), next_(pattern.size(), kNone), inverse_(pattern.size()), carry_(pattern.size()) {
  for (std::size_t j = 0; j < pattern.size(); ++j)
    if (pattern.first[j] < pattern.first[j + 1] && pattern.row[pattern.first[j]] == j + 1) next_[j] = pattern.first[j];
}

bool ConjugateGradients::prepare(const BlockMatrix& H, double damping) {
  damped_.diagonal = H.diagonal;
  damped_.below = H.below;
  for (Matrix6d& block : damped_.diagonal) block.diagonal() *= 1 + damping;
  for (std::size_t j = 0; j < damped_.size(); ++j) {
    Matrix6d pivot = damped_.diagonal[j];
    if (j > 0 && next_[j - 1] != kNone) pivot.noalias() -= carry_[j - 1] * damped_.below[next_[j - 1]].transpose();
    const Eigen::LLT<Matrix6d> llt(pivot);
    if (llt.info() != Eigen::Success) return false;
    inverse_[j] = llt.solve(Matrix6d::Identity());
    if (next_[j] != kNone) carry_[j].noalias() = damped_.below[next_[j]] * inverse_[j];
  }
  return true;
}

Eigen::VectorXd ConjugateGradients::precondition(const Eigen::VectorXd& r) const {
  Eigen::VectorXd z = r;
  for (std::size_t j = 0; j + 1 < next_.size(); ++j)
    if (next_[j] != kNone) z.segment<6>(row_of(j + 1)).noalias() -= carry_[j] * z.segment<6>(row_of(j));
  for (std::size_t j = next_.size(); j-- > 0;) {
    z.segment<6>(row_of(j)) = (inverse_[j] * z.segment<6>(row_of(j))).eval();
    if (next_[j] != kNone) z.segment<6>(row_of(j)).noalias() -= carry_[j].transpose() * z.segment<6>(row_of(j + 1));
  }
  return z;
}

ConjugateGradients::Answer ConjugateGradients::solve(const Eigen::VectorXd& b) const {
  Answer out{.x = Eigen::VectorXd::Zero(b.size())};
  Eigen::VectorXd r = b, z = precondition(r), p = z;
  double weight = r.dot(z);
  const double enough = kResidual * kResidual * weight;
  for (std::size_t i = 0; i < kMostIterations; ++i) {
    if (!(weight > enough)) {
      out.converged = true;
      return out;
    }
    const Eigen::VectorXd Hp = damped_.times(p);
    const double along = weight / p.dot(Hp);
    out.x += along * p;
    r -= along * Hp;
    z = precondition(r);
    const double before = weight;
    weight = r.dot(z);
    p = z + (weight / before) * p;
  }
  return out;
}

}  // namespace onemap::mapping
