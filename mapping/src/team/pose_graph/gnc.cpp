#include "gnc.hpp"

#include <algorithm>
#include <cmath>

namespace onemap::mapping {

namespace {

constexpr double kSettled = 1e-4;  // a weight so near 0 or 1 is that
constexpr std::uint32_t kLastSteps = 20;
constexpr double kLeastMu = 1e-3;

// The shape at which the worst of the links that count is half way out; nearly all of them are much better.
double first_shape(const std::vector<double>& squared_errors, const std::vector<double>& weights, double barc2,
                   double most) {
  double worst = 0;
  for (std::size_t i = 0; i < weights.size(); ++i)
    if (weights[i] > 0) worst = std::max(worst, squared_errors[i]);
  const double excess = 2 * worst - barc2;
  return excess > 0 ? std::clamp(barc2 / excess, std::min(kLeastMu, most), most) : most;
}

// So many rounds from here reach the last shape.
double latest_start(const GncConfig& config, std::uint32_t rounds) {
  double mu = config.mu_end;
  for (std::uint32_t i = 0; i < rounds; ++i) mu /= config.mu_step;
  return mu;
}

// The new weights. True: each is 0 or 1.
bool reweigh(const std::vector<double>& squared_errors, double barc2, double mu, std::vector<double>& weights) {
  bool settled = true;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    double w = gnc_weight(squared_errors[i], barc2, mu);
    if (w < kSettled) w = 0;
    if (w > 1 - kSettled) w = 1;
    settled &= w == 0 || w == 1;
    weights[i] = w;
  }
  return settled;
}

bool verdict(double weight, InUse::Link before, const GncConfig& config) {
  if (before == InUse::Link::used) return weight >= config.drop_below;
  return before == InUse::Link::dropped ? weight > config.return_above : weight >= 0.5;
}

}  // namespace

double gnc_weight(double squared_error, double barc2, double mu) {
  if (squared_error <= mu / (mu + 1) * barc2) return 1;
  if (squared_error >= (mu + 1) / mu * barc2) return 0;
  return std::sqrt(barc2 * mu * (mu + 1) / squared_error) - mu;
}

bool solve_graduated(LeastSquares& squares, std::vector<double>& weights, const std::vector<InUse::Link>& in_use,
                     const GncConfig& config, bool warm, SolveEffort& effort) {
  if (weights.empty()) return squares.optimise(weights, kLastSteps);
  const std::uint32_t rounds = warm ? config.rounds_warm : config.rounds_cold;
  double mu = first_shape(squares.squared_errors(), weights, config.barc2, warm ? config.mu_warm : config.mu_cold);
  mu = std::max(mu, latest_start(config, rounds));
  for (std::uint32_t round = 0; round < rounds && mu < config.mu_end; ++round, mu *= config.mu_step) {
    ++effort.rounds;
    const bool settled = reweigh(squares.squared_errors(), config.barc2, mu, weights);
    if (squares.optimise(weights, config.steps_a_round) && settled && mu >= config.mu_warm) break;
  }
  const std::vector<double> errors = squares.squared_errors();
  for (std::size_t i = 0; i < weights.size(); ++i)
    weights[i] = verdict(gnc_weight(errors[i], config.barc2, config.mu_end), in_use[i], config) ? 1 : 0;
  return squares.optimise(weights, kLastSteps);
}

}  // namespace onemap::mapping
