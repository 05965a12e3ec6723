// Whole teams by the simulator: invariants under any faults, and convergence when they are over.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/run.hpp"
#include "sim/watch.hpp"

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

// As it was before teams had keys, disks were full and records were replaced.
Scenario plain_of(std::uint64_t seed) {
  Scenario scenario = scenario_of(seed);
  scenario.sealed = false;
  scenario.sync_polls = 0;
  for (Write& write : scenario.writes) write.kind = kAlways;
  std::erase_if(scenario.faults, [](const Fault& fault) { return fault.kind == Fault::Kind::full_disk; });
  return scenario;
}

// What earlier versions did wrong, by the seed that found it.
TEST(FoundSeeds, StayWell) {
  for (const std::uint64_t seed : {156u, 198u, 372u, 395u, 416u, 518u, 596u,  603u,  672u,  785u,  869u,
                                   881u, 37u,  254u, 536u, 678u, 856u, 1673u, 2115u, 2981u, 5161u, 6018u})
    expect_well(plain_of(seed));
  for (const std::uint64_t seed : {5224u, 7124u, 9088u, 9729u}) expect_well(scenario_of(seed));  // teams with a key
}

// One property at a time, where the invariants must not break whatever else chance does.
Scenario plain(std::uint64_t seed) {
  Scenario scenario;
  scenario.seed = seed;
  scenario.robots = 4;
  scenario.edges = ring(4);
  scenario.chaos = 5s;
  for (std::size_t k = 0; k < 24; ++k)
    scenario.writes.push_back({150ms * k, k % 4, static_cast<std::uint8_t>(k % kLaneCount), 37 * k});
  return scenario;
}

TEST(Properties, ReplayedDatagramsAreTakenOnce) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Scenario scenario = plain(seed);
    scenario.links.duplication = 0.5;
    scenario.links.jitter = 4ms;
    expect_well(scenario);
  }
}

TEST(Properties, RecordsSpoiltOnTheWayAreNoRecords) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Scenario scenario = plain(seed);
    for (Write& write : scenario.writes) write.lane = 3, write.bytes = 6000;  // so that most bits are bodies
    scenario.links.flipped = 0.05;
    expect_well(scenario);
  }
}

TEST(Properties, PowerGoesAtAnyMomentAndNothingThatWasToldIsLost) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Scenario scenario = plain(seed);
    scenario.disks = true;
    for (std::size_t k = 0; k < 8; ++k) {
      Fault fault;
      fault.kind = Fault::Kind::crash;
      fault.at = 311ms * (k + 1), fault.lasts = 200ms, fault.robot = k % 4;
      scenario.faults.push_back(fault);
    }
    expect_well(scenario);
  }
}

// Who asks for more than the credit that it gives itself.
TEST(Properties, NobodyIsServedMoreThanItsCredit) {
  SimNet net(1, {});
  Watch watch(net);
  net.add_team(1, {});
  for (int k = 0; k < 20; ++k) net.append(0, 3, 50'000);
  const Endpoint asker = SimNet::address(9);
  std::uint32_t counter = 0;
  const auto say = [&](auto write) {
    std::array<std::uint8_t, kMaxDatagramBytes> buffer{};
    wire::Encoder out(buffer, {wire::DatagramType::unicast, 5, net[0].config.incarnation, ++counter});
    write(out);
    const auto bytes = std::span<const std::uint8_t>(buffer).first(out.size());
    watch.arrives(0, asker, bytes);
    net.inject(0, asker, bytes);
  };
  say([](wire::Encoder& out) { out.beacon({RobotId::from_name("asker"), 0, 0, 1, 0}); });
  std::vector<wire::WantEntry> entries;
  for (std::uint32_t seq = 0; seq < 20; ++seq)
    entries.push_back({{{numbered("robot", 0), 3, net[0].config.incarnation}, seq}, 0, 60});
  say([&](wire::Encoder& out) { out.want(100'000, entries); });
  for (int k = 0; k < 8; ++k) watch.moved(0);
  EXPECT_EQ(watch.what(), "");
  EXPECT_GT(net.node(0).counters().of(Refusal::want_over_credit), 0u);
}

// In a net without losses and with equal delays every record first comes along a shortest way: all of them.
TEST(Properties, FirstArrivalsTakeShortestWays) {
  std::size_t looked_at = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Random random(seed);
    constexpr std::size_t kRobots = 12;
    const auto edges = connected(kRobots, 8, random);
    SimNet net(seed, {.delay = 5ms});
    net.add_team(kRobots, edges);
    net.run_for(1s);
    for (std::size_t from = 0; from < kRobots; ++from) {
      const RecordId small = net.append(from, 1, 300), large = net.append(from, 3, 4000);
      ASSERT_TRUE(net.run_until([&] { return net.equal(); }, 10s));
      const auto way = distances(kRobots, edges, from);
      for (std::size_t to = 0; to < kRobots; ++to)
        for (const RecordId& id : {small, large}) {
          EXPECT_EQ(net.node(to).hops(id), way[to]) << seed << ": " << from << " to " << to;
          ++looked_at;
        }
      net.run_for(200ms);
    }
  }
  EXPECT_EQ(looked_at, 6u * 12 * 12 * 2);
}

}  // namespace
}  // namespace onemap::comms::sim
