#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <string>

#include "comms/memory_store.hpp"
#include "comms/wire.hpp"
#include "sim_net.hpp"

namespace onemap::comms {
namespace {
using namespace std::chrono_literals;
using sim::Edge;
using sim::LinkModel;
using sim::SimNet;

// Every robot holds what every robot wrote, body by body, given out once each and in log order.
void expect_same_records(SimNet& net) {
  for (std::size_t i = 1; i < net.size(); ++i) {
    ASSERT_EQ(net.node(i).frontier(), net.node(0).frontier()) << "robot " << i;
    EXPECT_EQ(net.node(i).frontier_digest(), digest(net.node(0).frontier()));
  }
  for (std::size_t i = 0; i < net.size(); ++i) {
    VersionVector seen;
    for (const auto& record : net[i].applied) {
      EXPECT_EQ(record->id.seq, seen[record->id.log]++);
      const auto original = net[0].store->find(record->id);
      ASSERT_NE(original, nullptr);
      EXPECT_EQ(record->kind, original->kind);
      EXPECT_EQ(record->body, original->body);
    }
    EXPECT_EQ(seen, net.node(i).frontier());
  }
}

void write_some(SimNet& net, std::size_t robot) {
  for (int k = 0; k < 10; ++k) net.append(robot, 1, 300, 3);
  for (int k = 0; k < 4; ++k) net.append(robot, 2, 20'000, 2);
  net.append(robot, 3, 150'000, 4);
  net.append(robot, 0, 0, 7);  // an empty body is a record, too
}

struct Shape {
  const char* name;
  std::vector<Edge> (*edges)(std::size_t);
};
constexpr Shape kShapes[] = {
    {"complete", sim::complete}, {"line", sim::line}, {"ring", sim::ring}, {"star", sim::star}};

TEST(Replication, ConvergesOnEveryGraphAtEveryLoss) {
  for (const Shape& shape : kShapes)
    for (const double loss : {0.0, 0.1, 0.2, 0.3}) {
      double seconds = 0.0, overhead = 0.0;
      for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        SimNet net(seed, {.loss = loss, .duplication = 0.02, .delay = 5ms, .jitter = 4ms});
        net.add_team(5, shape.edges(5));
        for (std::size_t i = 0; i < 5; ++i) write_some(net, i);
        const Instant start = net.now();
        ASSERT_TRUE(net.run_until([&] { return net.equal(); }, 60s))
            << shape.name << " loss " << loss << " seed " << seed;
        seconds += to_seconds(net.now() - start) / 5;
        overhead += static_cast<double>(net.bytes_carried()) / static_cast<double>(4 * net.useful_bytes()) / 5;
        net.run_for(5s);
        expect_same_records(net);
        EXPECT_LE(net.largest_datagram(), kMaxDatagramBytes);
      }
      printf("%-9s loss %2.0f %%: %.2f s to equal, sent / useful %.3f\n", shape.name, loss * 100, seconds, overhead);
      EXPECT_LE(overhead, 1.22 / (1.0 - loss)) << shape.name << " loss " << loss;
    }
}

TEST(Replication, SameSeedSameRun) {
  const auto run = [](std::uint64_t seed) {
    SimNet net(seed, {.loss = 0.2, .duplication = 0.05, .jitter = 10ms});
    net.add_team(4, sim::ring(4));
    for (std::size_t i = 0; i < 4; ++i) write_some(net, i);
    std::vector<std::uint64_t> all{};
    net.tap = [&](std::size_t to, const Endpoint&, std::span<const std::uint8_t> bytes) {
      all.push_back(wire::body_hash(static_cast<std::uint16_t>(to), bytes));
    };
    net.run_for(5s);
    return all;
  };
  EXPECT_EQ(run(4), run(4));
  EXPECT_NE(run(4), run(5));
}

TEST(Replication, LateJoinerGetsEverything) {
  for (const double loss : {0.0, 0.2}) {
    SimNet net(8, {.loss = loss, .jitter = 3ms});
    net.add_team(3, sim::line(3));
    for (std::size_t i = 0; i < 3; ++i) write_some(net, i);
    ASSERT_TRUE(net.run_until([&] { return net.equal(); }, 30s));
    NodeConfig late;
    late.peers = {SimNet::address(2)};  // it knows the last of the line; nobody knows it
    const std::size_t joiner = net.add(late);
    net.connect(2, joiner);
    const Instant start = net.now();
    ASSERT_TRUE(net.run_until([&] { return net.equal(); }, 30s));
    EXPECT_LT(net.now() - start, 2s);  // 0.7 MB at 4 MB/s
    write_some(net, joiner);
    ASSERT_TRUE(net.run_until([&] { return net.equal(); }, 30s));
    net.run_for(1s);
    expect_same_records(net);
  }
}

TEST(Replication, PartitionHeals) {
  for (const double loss : {0.0, 0.3}) {
    SimNet net(9, {.loss = loss, .jitter = 3ms});
    net.add_team(6, sim::ring(6));
    for (std::size_t i = 0; i < 6; ++i) net.append(i, 1, 500);
    ASSERT_TRUE(net.run_until([&] { return net.equal(); }, 30s));
    net.cut(2, 3);
    net.cut(0, 5);
    for (std::size_t i = 0; i < 6; ++i) write_some(net, i);
    net.run_for(60s);  // longer than neighbour_timeout
    EXPECT_FALSE(net.equal());
    EXPECT_EQ(net.node(0).frontier(), net.node(2).frontier());
    EXPECT_EQ(net.node(3).frontier(), net.node(5).frontier());
    EXPECT_GE(net.node(2).counters().neighbours_lost, 1u);
    net.connect(2, 3);
    net.connect(0, 5);
    const Instant healed = net.now();
    ASSERT_TRUE(net.run_until([&] { return net.equal(); }, 30s));
    // The next beacon may be 4 s away, and may be lost.
    EXPECT_LT(net.now() - healed, loss == 0.0 ? 6s : 16s);
    net.run_for(1s);
    expect_same_records(net);
  }
}

TEST(Replication, LargestRecordCrossesALine) {
  for (const double loss : {0.0, 0.1, 0.3}) {
    SimNet net(10, {.loss = loss, .duplication = 0.05, .delay = 2ms, .jitter = 2ms});
    net.add_team(3, sim::line(3));
    net.append(0, 3, kMaxRecordBytes);
    net.append(0, 3, kMaxRecordBytes - 1);
    net.append(2, 3, kMaxRecordBytes);
    const Instant start = net.now();
    ASSERT_TRUE(net.run_until([&] { return net.equal(); }, 60s));
    printf("line of 3, 3 MiB, loss %2.0f %%: %.2f s\n", loss * 100, to_seconds(net.now() - start));
    net.run_for(1s);
    expect_same_records(net);
    EXPECT_EQ(net.node(1).counters().of(Refusal::data_bad_hash), 0u);
  }
}

TEST(Replication, OwnRecordsThatCannotBeKeptAreRefusedWithTheReason) {
  MemoryStore store(2'000);
  NodeConfig config;
  config.self = RobotId::from_name("a");
  config.identity = sim::identity_of(config.self);
  Node node(config, store);
  const auto why = [&](std::uint8_t lane, std::size_t bytes) {
    const auto refused = node.append(Instant{}, lane, 1, std::vector<std::uint8_t>(bytes));
    return refused.ok() ? "kept" : refused.error().text();
  };
  EXPECT_THAT(why(3, kMaxRecordBytes + 1), testing::HasSubstr("1048577 bytes; a record holds at most 1048576"));
  EXPECT_THAT(why(kLaneCount, 1), testing::HasSubstr("lane 5 is unknown"));
  EXPECT_THAT(why(1, 3000), testing::HasSubstr("of 2000 bytes (network.store_budget_mb)"));
  EXPECT_EQ(node.counters().of(Refusal::append_refused), 3u);
  EXPECT_TRUE(node.frontier().empty());
}

// Delivered means that every living neighbour has said that it holds them.
TEST(Replication, DeliveredIsExact) {
  SimNet net(18, {.delay = 10ms});
  net.add_team(3, sim::star(3));
  net.run_for(1s);
  EXPECT_TRUE(net.node(0).delivered(4)) << "nothing was written";
  const RecordId pose = net.append(0, 1, 100);
  EXPECT_FALSE(net.node(0).delivered(1));
  EXPECT_TRUE(net.node(0).delivered(0)) << "of that lane there is nothing";
  const auto all_hold = [&](const RecordId& id) { return net.node(1).hops(id) && net.node(2).hops(id); };
  ASSERT_TRUE(net.run_until([&] { return net.node(0).delivered(1); }, 5s));
  EXPECT_TRUE(all_hold(pose));
  net[2].on = false;
  const RecordId next = net.append(0, 0, 100);
  net.run_for(3s);
  EXPECT_TRUE(net.node(1).hops(next));
  EXPECT_FALSE(net.node(0).delivered(1)) << "a neighbour that is believed alive has not said so";
  net.append(0, 3, 500'000);
  net.run_for(20s);
  EXPECT_TRUE(net.node(0).delivered(4)) << "it is not believed alive any longer";
}

TEST(Replication, WhoseRecordsAreMissingIsKnown) {
  SimNet net(19, {});
  NodeConfig slow;
  slow.bytes_per_second = 20'000;
  net.add_team(3, sim::line(3), slow);
  net.append(0, 3, 100'000);
  net.append(2, 0, 10);
  net.run_for(2s);
  EXPECT_EQ(net.node(1).incomplete(), std::set<RobotId>{RobotId::from_name("robot0")});
  EXPECT_EQ(net.node(1).records_missing(), 1u);
  EXPECT_TRUE(net.node(0).incomplete().empty());
  ASSERT_TRUE(net.run_until([&] { return net.equal(); }, 30s));
  for (std::size_t i = 0; i < 3; ++i) EXPECT_TRUE(net.node(i).incomplete().empty());
}

// Signs of life: of neighbours by datagrams, of others by what they say and write, over any number of hops.
TEST(Replication, ANodeOnAnOldStoreGivesEachRobotTimeToShowUp) {
  MemoryStore store(1u << 20);
  const RobotId other = RobotId::from_name("other");
  ASSERT_TRUE(store.append(sim::SignedLogs().next({other, 0, 4}, 1, {})));
  NodeConfig config;
  config.self = RobotId::from_name("a");
  Node node(config, store);
  const Instant start{1000s};
  node.on_timer(start);
  EXPECT_EQ(node.presence(start + 1s).at(other).last_sign, start);
  EXPECT_EQ(node.presence(start + 1s).at(other).incarnation, 4u);
  EXPECT_FALSE(node.team_agrees(0, {})) << "it has not said what it holds";
  EXPECT_TRUE(node.team_agrees(0, {other}));
}

TEST(Replication, PresenceKnowsWhenARobotLastShowedALifeSign) {
  SimNet net(20, {});
  net.add_team(3, sim::line(3));
  for (std::size_t i = 0; i < 3; ++i) net.append(i, 0, 10);
  ASSERT_TRUE(net.run_until([&] { return sim::agrees(net.node(0), 3, 0); }, 20s));
  const RobotId last = RobotId::from_name("robot2");
  net.run_for(10s);
  auto seen = net.node(0).presence(net.now());
  EXPECT_EQ(seen.size(), 3u);
  EXPECT_TRUE(seen.at(RobotId::from_name("robot1")).neighbour);
  EXPECT_FALSE(seen.at(last).neighbour);
  EXPECT_LT(net.now() - seen.at(RobotId::from_name("robot1")).last_sign, 6s);
  EXPECT_GT(net.now() - seen.at(last).last_sign, 8s) << "it has said nothing new";
  net.node(2).set_local_status(net.now(), 5, kStatusFinished);
  net.run_for(1s);
  seen = net.node(0).presence(net.now());
  EXPECT_LT(net.now() - seen.at(last).last_sign, 1s);
  EXPECT_EQ(seen.at(last).flags, kStatusFinished);
  net.run_for(10s);
  net.append(2, 3, 10);
  net.run_for(1s);
  EXPECT_LT(net.now() - net.node(0).presence(net.now()).at(last).last_sign, 1s);
}

TEST(Replication, NothingIsSentWithoutNeedWhenIdle) {
  SimNet net(14, {.delay = 2ms});
  net.add_team(3, sim::line(3));
  for (std::size_t i = 0; i < 3; ++i) write_some(net, i);
  net.run_for(20s);
  ASSERT_TRUE(net.equal());
  const std::uint64_t before = net.bytes_carried();
  net.run_for(60s);
  EXPECT_LT(net.bytes_carried() - before, 60u * 3 * 150);  // bytes/s a robot
  EXPECT_EQ(net.node(1).counters().duplicate_body_bytes, 0u);
}

TEST(Replication, SmallReassemblyBudgetIsEnough) {
  SimNet net(15, {.loss = 0.1, .jitter = 3ms});
  NodeConfig config;
  config.reassembly_bytes = 300'000;
  net.add_team(3, sim::line(3), config);
  for (int k = 0; k < 20; ++k) {
    net.append(0, 3, 100'000);
    net.append(2, 2, 60'000);
  }
  ASSERT_TRUE(net.run_until([&] { return net.equal(); }, 120s));
  net.run_for(1s);
  expect_same_records(net);
}

TEST(Replication, FullStoreRefusesVoxelsAndKeepsPosesComing) {
  SimNet net(16, {});
  NodeConfig config;
  config.peers = {SimNet::address(1)};
  net.add(config);
  config.peers = {SimNet::address(0)};
  net.add(config, 500'000);
  net.connect(0, 1);
  for (int k = 0; k < 10; ++k) net.append(0, 3, 100'000);
  for (int k = 0; k < 30; ++k) net.append(0, 1, 100);
  const LogId poses{RobotId::from_name("robot0"), 1, 1};
  ASSERT_TRUE(net.run_until(
      [&] { return net.node(1).frontier().contains(poses) && net.node(1).frontier().at(poses) == 30; }, 10s));
  net.run_for(5s);
  EXPECT_GT(net.node(1).counters().of(Refusal::store_refused), 0u);
  EXPECT_LE(net[1].store->bytes(), 500'000u);
  EXPECT_THAT(net.node(1).store_full(), testing::HasSubstr("network.store_budget_mb"));
  EXPECT_EQ(net.node(0).store_full(), "");
  EXPECT_LT(net.node(1).counters().bytes_received, 1'500'000u);  // what has no room is not fetched again and again
}

TEST(Replication, AnotherNeighbourTakesOver) {
  SimNet net(17, {.delay = 3ms});
  net.add_team(4, {{0, 1}, {0, 2}, {1, 3}, {2, 3}});
  for (int k = 0; k < 8; ++k) net.append(0, 3, 200'000);
  ASSERT_TRUE(net.run_until(
      [&] {
        return net.node(1).frontier() == net.node(0).frontier() && net.node(2).frontier() == net.node(0).frontier();
      },
      10s));
  ASSERT_FALSE(net.equal());  // the last one is still being served, by both
  net[1].on = false;
  const Instant start = net.now();
  ASSERT_TRUE(net.run_until([&] { return net.equal(); }, 10s));
  EXPECT_LT(net.now() - start, 3s);
  EXPECT_GT(net.node(3).counters().records_retargeted, 0u);
}

// Both neighbours are silent for a while, and one of them stays away: all is asked of the other one at once, and not
// when the first is given up as a neighbour.
TEST(Replication, ANeighbourOutOfReachHoldsNothingUp) {
  sim::SimNet net(11, {});
  net.add_team(3, sim::complete(3));
  const auto part = [&](std::size_t from, bool apart) {
    for (const auto& [a, b] : {std::pair{from, std::size_t{2}}, std::pair{std::size_t{2}, from}})
      apart ? net.block(a, b) : net.unblock(a, b);
  };
  ASSERT_TRUE(net.run_until([&] { return net.node(2).neighbours().size() == 2; }, 5s));
  net.run_for(1s);
  for (const std::size_t from : {0u, 1u}) part(from, true);
  for (int k = 0; k < 10; ++k) net.append(0, 3, 100'000);
  ASSERT_TRUE(net.run_until([&] { return net.node(1).frontier() == net.node(0).frontier(); }, 30s));
  for (const std::size_t from : {0u, 1u}) part(from, false);
  ASSERT_TRUE(net.run_until([&] { return !net.node(2).frontier().empty(); }, 10s)) << "it has begun to ask";
  for (const std::size_t from : {0u, 1u}) part(from, true);
  net.run_for(3s);
  ASSERT_LT(net.node(2).frontier().begin()->second, 10u);
  part(1, false);
  EXPECT_TRUE(net.run_until([&] { return net.node(2).frontier() == net.node(1).frontier(); }, 8s));
}

// Random graphs, links, budgets, records and cuts: whatever happened, a connected team becomes equal, and says so.
TEST(Replication, RandomTeamsAlwaysBecomeEqual) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    sim::Random random(seed);
    const auto ms = [&](std::uint64_t below) { return std::chrono::milliseconds(random.below(below)); };
    LinkModel model{.loss = 0.1 * static_cast<double>(random.below(4)),
                    .duplication = 0.03,
                    .delay = 1ms + ms(30),
                    .jitter = ms(20)};
    const std::size_t n = 2 + random.below(5);
    auto edges = sim::line(n);
    for (std::uint64_t k = random.below(4); k > 0; --k) {
      const std::size_t a = random.below(n), b = random.below(n);
      if (a != b) edges.emplace_back(std::minmax(a, b));
    }
    NodeConfig config;
    if (random.below(2) == 0) config.credit_bytes = 10'000 + random.below(100'000);
    if (random.below(2) == 0) config.reassembly_bytes = random.below(2'000'000);
    if (random.below(2) == 0) config.bytes_per_second = 500'000 + random.below(5'000'000);
    SimNet net(seed, model);
    net.add_team(n, edges, config);
    for (int phase = 0; phase < 3; ++phase) {
      for (std::size_t i = 0; i < n; ++i)
        for (std::uint64_t k = random.below(6); k > 0; --k) {
          const auto lane = static_cast<std::uint8_t>(random.below(kLaneCount));
          net.append(i, lane, random.below(lane < 2 ? 2000 : random.below(8) == 0 ? 500'000 : 20'000));
        }
      const Edge edge = edges[random.below(edges.size())];
      net.cut(edge.first, edge.second);
      net.run_for(ms(3000));
    }
    for (const Edge& edge : edges) net.connect(edge.first, edge.second);
    const auto agree = [&] {
      for (std::size_t i = 0; i < n; ++i)
        if (!sim::agrees(net.node(i), n, 0)) return false;
      return true;
    };
    ASSERT_TRUE(net.run_until([&] { return net.equal(); }, 60s)) << "seed " << seed;
    ASSERT_TRUE(net.run_until(agree, 60s)) << "seed " << seed;
    expect_same_records(net);
    for (std::size_t i = 0; i < n; ++i) {
      EXPECT_EQ(net.node(i).counters().of(Refusal::data_conflict), 0u) << "seed " << seed;
      EXPECT_EQ(net.node(i).counters().of(Refusal::bad_frame), 0u) << "seed " << seed;
      EXPECT_EQ(net.node(i).records_missing(), 0u) << "seed " << seed;
    }
  }
}

}  // namespace
}  // namespace onemap::comms
