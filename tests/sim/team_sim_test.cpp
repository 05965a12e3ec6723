// Whole teams by the simulator: invariants under any faults, and convergence when they are over.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>

#include "sim/run.hpp"

namespace onemap::comms::sim {
namespace {
using namespace std::chrono_literals;

// A failure says its seed and the least of the scenario that still fails. `onemap_sim --seeds 1 --from SEED --trace`
// shows its datagrams.
void expect_well(const Scenario& scenario) {
  const Outcome outcome = run(scenario);
  if (outcome.failure.empty()) return;
  const Scenario least = shrink(scenario);
  ADD_FAILURE() << text_of(scenario) << "  " << outcome.failure << "\nthe least of it that fails: " << text_of(least)
                << "  " << run(least).failure;
}

class Seeds : public testing::TestWithParam<std::uint64_t> {};
constexpr std::uint64_t kSeeds = 1000, kShards = 4;

TEST_P(Seeds, AllIsWell) {
  std::uint64_t looks = 0, records = 0;
  for (std::uint64_t seed = GetParam(); seed <= kSeeds; seed += kShards) {
    expect_well(scenario_of(seed));
    if (HasFailure()) break;
  }
  const Outcome one = run(scenario_of(GetParam()));
  looks += one.looks, records += one.records;
  EXPECT_GT(looks, 100u);
  EXPECT_GT(records, 0u);
}
INSTANTIATE_TEST_SUITE_P(All, Seeds, testing::Range<std::uint64_t>(1, 1 + kShards));

// What earlier versions did wrong, by the seed that found it.
TEST(FoundSeeds, StayWell) {
  for (const std::uint64_t seed : {372u, 416u, 596u, 603u, 672u}) expect_well(scenario_of(seed));
}

}  // namespace
}  // namespace onemap::comms::sim
