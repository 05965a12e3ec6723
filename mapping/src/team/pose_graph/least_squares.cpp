#include "least_squares.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace onemap::mapping {

namespace {

constexpr std::size_t kOut = NormalEquations::kFixed;
// Keeps what hangs on nothing where it is, and is nothing beside what hangs.
constexpr double kLeastDamping = 1e-9, kFirstDamping = 1e-4, kMostDamping = 1e6;
constexpr double kSmallStep = 1e-6;  // radians and metres: a tenth of what records can say

}  // namespace

std::size_t LeastSquares::variable(std::size_t pose) const {
  if (pose == problem_.fixed) return NormalEquations::kFixed;
  return pose < problem_.fixed ? pose : pose - 1;
}

// Links without weight stay out of the equations, so that wrong ones do not fill the factor; when one comes in, what
// is where is found again, with all that were ever in.
void LeastSquares::prepare(const std::vector<double>& weights) {
  bool fits = equations_ != nullptr;
  slot_.resize(problem_.links.size(), kOut);
  for (std::size_t i = 0; i < weights.size() && fits; ++i) fits = weights[i] <= 0 || slot_[i] != kOut;
  if (fits) return;
  std::vector<NormalEquations::Pair> edges;
  edges.reserve(problem_.odometry.size() + weights.size());
  for (const GraphEdge& edge : problem_.odometry) edges.push_back(variables(edge));
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (weights[i] <= 0 && slot_[i] == kOut) continue;
    slot_[i] = edges.size();
    edges.push_back(variables(problem_.links[i]));
  }
  equations_ = std::make_unique<NormalEquations>(problem_.poses.size() - 1, edges, preference_);
}

void LeastSquares::assemble(const std::vector<double>& weights) {
  const auto add = [&](std::size_t slot, double weight, const GraphEdge& edge) {
    equations_->add(slot, weight, linearise(edge, problem_.poses[edge.a], problem_.poses[edge.b]), edge.information);
  };
  equations_->clear();
  for (std::size_t i = 0; i < problem_.odometry.size(); ++i) add(i, 1, problem_.odometry[i]);
  for (std::size_t i = 0; i < weights.size(); ++i)
    if (weights[i] > 0) add(slot_[i], weights[i], problem_.links[i]);
}

double LeastSquares::cost(const std::vector<double>& weights) const {
  double sum = 0;
  const std::vector<Pose>& X = problem_.poses;
  for (const GraphEdge& edge : problem_.odometry) sum += squared_error(edge, X[edge.a], X[edge.b]);
  for (std::size_t i = 0; i < weights.size(); ++i)
    if (weights[i] > 0) {
      const GraphEdge& edge = problem_.links[i];
      sum += weights[i] * squared_error(edge, X[edge.a], X[edge.b]);
    }
  return sum;
}

std::vector<Pose> LeastSquares::moved_by(const Eigen::VectorXd& step) const {
  std::vector<Pose> out = problem_.poses;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const std::size_t v = variable(i);
    if (v == NormalEquations::kFixed) continue;
    out[i] = out[i] * small_motion(step.segment<6>(static_cast<Eigen::Index>(6 * v)));
    out[i].R = orthonormal(out[i].R);
  }
  return out;
}

bool LeastSquares::step(const std::vector<double>& weights) {
  assemble(weights);
  const double before = cost_ ? *cost_ : cost(weights);
  for (; damping_ <= kMostDamping; damping_ = std::max(kFirstDamping, 10 * damping_)) {
    ++effort_.factorisations;
    if (!equations_->factor(std::max(damping_, kLeastDamping))) continue;
    const auto [by, exact] = equations_->step();
    if (!by.allFinite()) continue;
    std::vector<Pose> moved = moved_by(by);
    std::swap(moved, problem_.poses);
    const bool small = exact && by.cwiseAbs().maxCoeff() < kSmallStep;
    // A cost of rounding errors may go either way; a small step is the end in any case.
    if (const double after = cost(weights); after <= before || small) {
      cost_ = after;
      damping_ = damping_ > kFirstDamping ? damping_ / 10 : 0;
      return small;
    }
    std::swap(moved, problem_.poses);
  }
  damping_ = 0;
  return true;  // no step makes it better
}

bool LeastSquares::optimise(const std::vector<double>& weights, std::uint32_t steps) {
  if (problem_.poses.size() < 2 || weights == settled_) return true;
  prepare(weights);
  settled_.reset();
  cost_.reset();
  for (std::uint32_t i = 0; i < steps; ++i)
    if (step(weights)) {
      settled_ = weights;
      return true;
    }
  return false;
}

std::vector<double> LeastSquares::squared_errors() const {
  std::vector<double> out;
  for (const GraphEdge& edge : problem_.links)
    out.push_back(squared_error(edge, problem_.poses[edge.a], problem_.poses[edge.b]));
  return out;
}

std::optional<double> LeastSquares::surprise(std::size_t link) const {
  const GraphEdge& edge = problem_.links[link];
  const Linearised at = linearise(edge, problem_.poses[edge.a], problem_.poses[edge.b]);
  const auto of_others = equations_->covariance(variables(edge), at);
  if (!of_others) return std::nullopt;
  const Matrix6d covariance = edge.information.llt().solve(Matrix6d::Identity()) + *of_others;
  return at.error.dot(covariance.ldlt().solve(at.error));
}

}  // namespace onemap::mapping
