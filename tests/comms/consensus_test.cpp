// Consensus against figures that were computed from the weight matrices' eigenvalues (ARCHITECTURE.md cites them).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

#include "comms/consensus/linear_iteration.hpp"
#include "comms/consensus/running_sums.hpp"
#include "sim/topology.hpp"

namespace onemap::comms {
namespace {
using sim::Edge;
using sim::Random;
using Values = std::vector<double>;

std::vector<std::vector<std::size_t>> neighbours_of(std::size_t n, const std::vector<Edge>& edges) {
  std::vector<std::vector<std::size_t>> out(n);
  for (const auto& [a, b] : edges) out[a].push_back(b), out[b].push_back(a);
  return out;
}

// Equation (3), robot by robot. What is lost is not there for who should have heard it.
Values step(const Values& x, const std::vector<std::vector<std::size_t>>& near, double loss, Random& random) {
  Values next(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    double own = x[i];
    for (const std::size_t j : near[i])
      if (loss == 0 || random.unit() >= loss) own += metropolis_weight(near[i].size(), near[j].size()) * (x[j] - x[i]);
    next[i] = own;
    if (loss > 0) continue;
    std::vector<NeighbourValue> said;
    for (const std::size_t j : near[i]) said.push_back({x[j], near[j].size()});
    EXPECT_NEAR(linear_iteration(x[i], said), own, 1e-12);
  }
  return next;
}

double mean(const Values& x) {
  double sum = 0;
  for (const double value : x) sum += value;
  return sum / static_cast<double>(x.size());
}
double distance(const Values& x, double to) {
  double sum = 0;
  for (const double value : x) sum += (value - to) * (value - to);
  return std::sqrt(sum);
}

// The error shrinks by the second largest eigenvalue a step, once the others are gone; so that is measured, and the
// iterations to a millionth follow.
int iterations_to_a_millionth(std::size_t n, const std::vector<Edge>& edges) {
  const auto near = neighbours_of(n, edges);
  Random random(1);
  Values x(n);
  for (double& value : x) value = random.normal(1.0);
  const double goal = mean(x);
  for (double& value : x) value -= goal;
  double rate = 0;
  for (int k = 0; k < 4000; ++k) {
    const double before = distance(x, 0);
    x = step(x, near, 0, random);
    const double after = distance(x, 0);
    rate = after / before;
    // Or it would be too small to measure beside what rounding leaves of the mean.
    const double rest = mean(x);
    for (double& value : x) value = (value - rest) / after;
  }
  return static_cast<int>(std::ceil(std::log(1e-6) / std::log(rate)));
}

TEST(LinearIteration, TakesAsManyStepsAsItsEigenvaluesSay) {
  EXPECT_EQ(iterations_to_a_millionth(4, sim::line(4)), 64);
  EXPECT_EQ(iterations_to_a_millionth(5, sim::line(5)), 102);
  EXPECT_EQ(iterations_to_a_millionth(10, sim::line(10)), 417);
  EXPECT_EQ(iterations_to_a_millionth(10, sim::ring(10)), 102);
  EXPECT_EQ(iterations_to_a_millionth(20, sim::ring(20)), 417);
  EXPECT_NEAR(iterations_to_a_millionth(10, sim::star(10)), 132, 1);
}

TEST(LinearIteration, ACompleteGraphAgreesAtOnce) {
  Random random(2);
  const Values x = step({1, 2, 3, 6}, neighbours_of(4, sim::complete(4)), 0, random);
  for (const double value : x) EXPECT_NEAR(value, 3, 1e-12);
}

// They agree, but not on the mean: what is lost is gone.
TEST(LinearIteration, LossMakesThemAgreeOnSomethingElse) {
  const auto near = neighbours_of(10, sim::ring(10));
  for (const auto& [loss, bias] : {std::pair{0.01, 0.039}, {0.1, 0.098}, {0.3, 0.129}}) {
    double sum = 0;
    constexpr int kTrials = 60;
    for (int trial = 0; trial < kTrials; ++trial) {
      Random random(100 + static_cast<std::uint64_t>(trial));
      Values x(10);
      for (double& value : x) value = random.normal(1.12);
      const double goal = mean(x);
      for (int k = 0; k < 600; ++k) x = step(x, near, loss, random);
      EXPECT_LT(distance(x, mean(x)), 1e-3) << "they agree";
      sum += (mean(x) - goal) * (mean(x) - goal);
    }
    const double rms = std::sqrt(sum / kTrials);
    printf("ring of 10, loss %2.0f %%: rms bias %.3f\n", 100 * loss, rms);
    EXPECT_GT(rms, bias / 2);
    EXPECT_LT(rms, bias * 2);
  }
}

struct Team {
  Team(std::size_t n, const std::vector<Edge>& edges, std::uint64_t seed)
      : near(neighbours_of(n, edges)), random(seed) {
    for (std::size_t i = 0; i < n; ++i) {
      values.push_back(random.normal(1.0));
      robots.emplace_back(Mass{values.back(), 1.0});
    }
  }
  static RobotId id(std::size_t i) { return RobotId::from_name("r" + std::to_string(i)); }
  void round(double loss, double again = 0) {
    for (std::size_t i = 0; i < robots.size(); ++i) {
      std::vector<RunningSums::Link> links;
      for (const std::size_t j : near[i]) links.push_back({id(j), metropolis_weight(near[i].size(), near[j].size())});
      robots[i].round(links);
    }
    for (std::size_t i = 0; i < robots.size(); ++i)
      for (const std::size_t j : near[i])
        for (int copies = random.unit() < again ? 2 : 1; copies > 0; --copies)
          if (random.unit() >= loss) {
            EXPECT_TRUE(robots[j].heard(id(i), robots[i].given_to(id(j))));
          }
  }
  double worst() const {
    double most = 0;
    for (const auto& robot : robots) most = std::max(most, std::abs(robot.value(1e9) - mean(values)));
    return most;
  }
  std::vector<std::vector<std::size_t>> near;
  Random random;
  Values values;
  std::vector<RunningSums> robots;
};

TEST(RunningSums, AreExactInSpiteOfLossAndCopies) {
  for (const double loss : {0.0, 0.1, 0.3}) {
    Team team(10, sim::ring(10), 7);
    for (int k = 0; k < 600; ++k) team.round(loss, 0.2);
    printf("ring of 10, loss %2.0f %%: worst error of running sums %.1e\n", 100 * loss, team.worst());
    EXPECT_LT(team.worst(), 1e-9);
  }
}

TEST(RunningSums, NeedAsLongAsTheIteration) {
  Team team(4, sim::line(4), 9);
  for (int k = 0; k < 64; ++k) team.round(0);
  EXPECT_LT(team.worst(), 1e-5);
  EXPECT_GT(team.worst(), 1e-8);
}

// One at one robot and 0 at the others: the sum, here of robots.
TEST(RunningSums, CountTheTeam) {
  Team team(12, sim::ring(12), 11);
  for (std::size_t i = 0; i < 12; ++i) team.robots[i] = RunningSums({1.0, i == 0 ? 1.0 : 0.0});
  EXPECT_EQ(team.robots[5].value(-1), -1) << "it does not know yet";
  for (int k = 0; k < 600; ++k) team.round(0.2);
  for (const auto& robot : team.robots) EXPECT_NEAR(robot.value(-1), 12, 1e-6);
}

TEST(RunningSums, TakeNoNumberThatIsNone) {
  RunningSums robot({2.0, 1.0});
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();
  for (const Mass& bad : {Mass{kNan, 1}, Mass{1, kNan}, Mass{kInf, 1}, Mass{1, -kInf}, Mass{1e16, 1}, Mass{1, 1e300}})
    EXPECT_FALSE(robot.heard(RobotId::from_name("liar"), bad));
  EXPECT_EQ(robot.held(), (Mass{2.0, 1.0}));
}

}  // namespace
}  // namespace onemap::comms
