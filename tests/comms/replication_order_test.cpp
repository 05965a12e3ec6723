// What comes first, and how fast: the shortest path, poses before voxels, no more than is allowed a second.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <vector>

#include "comms/wire.hpp"
#include "sim_net.hpp"

namespace onemap::comms {
namespace {

using namespace std::chrono_literals;
using sim::Edge;
using sim::SimNet;

std::vector<int> distances(std::size_t n, const std::vector<Edge>& edges, std::size_t from) {
  std::vector<int> distance(n, -1);
  distance[from] = 0;
  for (std::size_t round = 0; round < n; ++round)
    for (const auto& [a, b] : edges) {
      if (distance[a] >= 0 && (distance[b] < 0 || distance[b] > distance[a] + 1)) distance[b] = distance[a] + 1;
      if (distance[b] >= 0 && (distance[a] < 0 || distance[a] > distance[b] + 1)) distance[a] = distance[b] + 1;
    }
  return distance;
}

TEST(ReplicationOrder, FirstArrivalTakesAShortestPath) {
  constexpr std::size_t kRobots = 9;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    sim::Random random(seed);
    auto edges = sim::line(kRobots);  // connected, with random short cuts
    for (int k = 0; k < 5; ++k) {
      const std::size_t a = random.below(kRobots), b = random.below(kRobots);
      if (a != b) edges.emplace_back(std::minmax(a, b));
    }
    SimNet net(seed, {.delay = 5ms});
    net.add_team(kRobots, edges);
    net.run_for(1s);
    for (std::size_t from = 0; from < kRobots; ++from) {
      const RecordId small = net.append(from, 1, 400), large = net.append(from, 3, 8000);
      ASSERT_TRUE(net.run_until([&] { return net.equal(); }, 10s));
      const auto distance = distances(kRobots, edges, from);
      for (std::size_t to = 0; to < kRobots; ++to) {
        EXPECT_EQ(net.node(to).hops(small), distance[to]) << seed << ": " << from << " to " << to;
        EXPECT_EQ(net.node(to).hops(large), distance[to]) << seed << ": " << from << " to " << to;
      }
      net.run_for(200ms);
    }
  }
}

TEST(ReplicationOrder, PosesOvertakeVoxels) {
  SimNet net(12, {.delay = 2ms});
  NodeConfig slow;
  slow.bytes_per_second = 200'000;
  net.add_team(2, sim::line(2), slow);
  net.run_for(1s);
  for (int k = 0; k < 4; ++k) net.append(0, 3, 500'000);  // ten seconds of traffic
  net.run_for(2s);
  for (int k = 0; k < 5; ++k) {
    const RecordId pose = net.append(0, 1, 400);
    const Instant start = net.now();
    ASSERT_TRUE(net.run_until([&] { return net.node(1).hops(pose).has_value(); }, 5s));
    EXPECT_LT(net.now() - start, 100ms);
    net.run_for(300ms);
  }
  EXPECT_FALSE(net.equal());
}

TEST(ReplicationOrder, BodiesArePaced) {
  SimNet net(13, {.delay = 1ms});
  NodeConfig config;
  config.bytes_per_second = 1'000'000;
  config.train_datagrams = 8;
  net.add_team(2, sim::line(2), config);
  net.run_for(1s);
  std::vector<std::pair<Instant, std::size_t>> arrivals;
  net.tap = [&](std::size_t to, const Endpoint&, std::span<const std::uint8_t> bytes) {
    if (to == 1) arrivals.emplace_back(net.now(), bytes.size());
  };
  net.append(0, 3, 1'000'000);
  ASSERT_TRUE(net.run_until([&] { return net.equal(); }, 10s));
  std::size_t most = 0, sum = 0;
  for (std::size_t first = 0, last = 0; last < arrivals.size(); ++last) {
    sum += arrivals[last].second;
    while (arrivals[last].first - arrivals[first].first >= 10ms) sum -= arrivals[first++].second;
    most = std::max(most, sum);
  }
  EXPECT_LE(most, 10'000u + 10 * kMaxDatagramBytes);  // 10 ms of the rate, a train, and a little control
  EXPECT_GE(arrivals.size(), 900u);
}

}  // namespace
}  // namespace onemap::comms
