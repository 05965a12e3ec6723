#pragma once
#include <memory>
#include <optional>
#include <vector>

#include "mapping/team/pose_graph_solution.hpp"
#include "normal_equations.hpp"

namespace onemap::mapping {

// One component's anchors, one of them fixed, and the edges between them (a, b: their place in `poses`). Everything
// hangs on the fixed one by odometry and links of weight above 0, or keeps its place.
struct PoseProblem {
  std::vector<Pose> poses;
  std::size_t fixed = 0;
  std::vector<GraphEdge> odometry{}, links{};
};

// Weighted least squares over a PoseProblem: Gauss-Newton, damped when a step made it worse (Levenberg-Marquardt).
class LeastSquares {
 public:
  LeastSquares(PoseProblem& problem, SolveEffort& effort) : problem_(problem), effort_(effort) {}

  // At most so many steps, with a weight for each link. True: the last step moved nothing worth a name.
  bool optimise(const std::vector<double>& weights, std::uint32_t steps);

  std::vector<double> squared_errors() const;  // of the links, in sigmas
  // Chi square of a link that had no weight in the last `optimise`: its error against what it and all others are
  // unsure of. Nothing where that would cost too much.
  std::optional<double> surprise(std::size_t link) const;
  // From here on equations are solved the cheapest way; until then such that `surprise` has an answer, if it can be.
  void no_more_surprises() { preference_ = 1; }

 private:
  void prepare(const std::vector<double>& weights);
  void assemble(const std::vector<double>& weights);
  double cost(const std::vector<double>& weights) const;
  bool step(const std::vector<double>& weights);  // true: small
  std::vector<Pose> moved_by(const Eigen::VectorXd& step) const;
  std::size_t variable(std::size_t pose) const;
  NormalEquations::Pair variables(const GraphEdge& edge) const { return {variable(edge.a), variable(edge.b)}; }

  PoseProblem& problem_;
  SolveEffort& effort_;
  std::size_t preference_ = 30;  // a factor for the surprises of many links saves more than it costs
  std::unique_ptr<NormalEquations> equations_;
  std::vector<std::size_t> slot_;  // of each link in the equations; kFixed: it is not in them
  double damping_ = 0;
  std::optional<double> cost_;                  // of the poses as they are, under the weights of this `optimise`
  std::optional<std::vector<double>> settled_;  // the weights that nothing moves under any more
};

}  // namespace onemap::mapping
