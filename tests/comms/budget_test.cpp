// What a link may cost, and what it did.
#include <gtest/gtest.h>

#include "rate/link_budget.hpp"
#include "sim_net.hpp"
#include "support/paced_net.hpp"
#include "traffic_count.hpp"

namespace onemap::comms {
namespace {
using namespace std::chrono_literals;
using paced::PacedNet;

const Instant kDayBegan{100s};

TEST(LinkBudget, NoLimitAllowsAll) {
  LinkBudget budget;
  budget.spent(kDayBegan, 1'000'000'000);
  EXPECT_TRUE(budget.allows(kDayBegan));
}

TEST(LinkBudget, ASecondsWorthMayBeSavedUp) {
  LinkBudget budget(1000, 0);
  budget.spent(kDayBegan, 1000);
  EXPECT_TRUE(budget.allows(kDayBegan));
  budget.spent(kDayBegan, 500);
  EXPECT_FALSE(budget.allows(kDayBegan));
  EXPECT_EQ(budget.next(kDayBegan), kDayBegan + 500ms);
  EXPECT_TRUE(budget.allows(kDayBegan + 500ms));
}

TEST(LinkBudget, ADayIs24HoursFromItsFirstByte) {
  LinkBudget budget(0, 1000);
  budget.spent(kDayBegan, 999);
  EXPECT_TRUE(budget.allows(kDayBegan));
  budget.spent(kDayBegan + 1h, 1);
  EXPECT_FALSE(budget.allows(kDayBegan + 1h));
  EXPECT_EQ(budget.next(kDayBegan + 1h), kDayBegan + 24h);
  EXPECT_EQ(budget.spent_today(kDayBegan + 2h), 1000u);
  EXPECT_TRUE(budget.allows(kDayBegan + 24h));
  EXPECT_EQ(budget.spent_today(kDayBegan + 24h), 0u);
  budget.spent(kDayBegan + 30h, 10);
  EXPECT_EQ(budget.spent_today(kDayBegan + 30h), 10u);
}

struct Two {
  PacedNet net{1};
  explicit Two(NodeConfig config = {}) {
    for (const std::size_t other : {1u, 0u}) {
      config.peers = {PacedNet::address(other)};
      net.add(config);
    }
    net.route(0, 1, net.link({}));
    net.route(1, 0, net.link({}));
    net.run_for(1s);
  }
  const NeighbourStatus status(std::size_t i) { return net.node(i).neighbours().at(0); }
};

TEST(Budget, BeyondItOnlyControlAndPosesGo) {
  NodeConfig config;
  config.link_budget_bytes_per_second = 50'000;
  Two two(config);
  std::size_t poses = 0;
  two.net[1].applied = [&](const Record& record) { poses += record.id.log.lane == 1 ? 1u : 0u; };
  two.net.feed(0, 1, 20'000, 1'000'000);
  two.net.every(100ms, [&] { two.net.append(0, 1, 200); });
  two.net.run_for(2s);
  const auto before = two.status(0).bytes_in + two.status(0).bytes_out;
  const std::size_t poses_before = poses;
  two.net.run_for(20s);
  const double each_second = static_cast<double>(two.status(0).bytes_in + two.status(0).bytes_out - before) / 20;
  EXPECT_LE(each_second, 52'000);
  EXPECT_GE(each_second, 30'000) << "what is allowed is used";
  EXPECT_EQ(poses - poses_before, 200u);
}

TEST(Budget, WhatADayAllowsIsSpentAndThenNothingButPosesComes) {
  NodeConfig config;
  config.link_budget_bytes_per_day = 3'000'000;
  Two two(config);
  std::size_t poses = 0;
  two.net[1].applied = [&](const Record& record) { poses += record.id.log.lane == 1 ? 1u : 0u; };
  two.net.feed(0, 1, 20'000, 1'000'000);
  two.net.run_for(10s);
  EXPECT_FALSE(two.status(0).within_budget);
  EXPECT_GE(two.status(0).bytes_today, 3'000'000u);
  const auto spent = two.net.node(1).counters().body_bytes_received;
  EXPECT_GT(spent, 2'500'000u);
  two.net.append(0, 1, 200);
  two.net.run_for(10s);
  EXPECT_EQ(poses, 1u);
  EXPECT_LE(two.net.node(1).counters().body_bytes_received - spent, 1000u);
}

TEST(Traffic, EveryByteIsCountedByKindAndPeer) {
  Two two;
  two.net.append(0, 0, 100);
  two.net.append(0, 1, 2000);
  two.net.append(0, 3, 100'000);
  two.net.run_for(5s);
  for (const std::size_t i : {0u, 1u}) {
    const NeighbourStatus status = two.status(i);
    EXPECT_EQ(status.traffic.in.total(), status.bytes_in);
    EXPECT_EQ(status.traffic.out.total(), status.bytes_out);
    EXPECT_GT(status.traffic.out.frames[0], 0u);
    EXPECT_GT(status.traffic.out.frames[index_of(FrameType::beacon)], 0u);
  }
  const Traffic::Way out = two.status(0).traffic.out;
  EXPECT_EQ(out, two.status(1).traffic.in) << "nothing is lost here";
  EXPECT_GT(out.data[0], 100u);
  EXPECT_GT(out.data[1], 2000u);
  EXPECT_GT(out.data[3], 100'000u);
  EXPECT_EQ(out.data[2] + out.data[4] + out.frames[index_of(FrameType::data)], 0u);
  EXPECT_GT(two.status(1).traffic.out.frames[index_of(FrameType::want)], 0u);
  EXPECT_GT(two.status(1).traffic.out.frames[index_of(FrameType::feedback)], 0u);
}

TEST(Traffic, FramesThatAreNotKnownAreHeaders) {
  Traffic::Way way;
  count_traffic(way, std::vector<std::uint8_t>{200, 2, 0, 1, 1, 7, 4, 0, 1, 2, 3, 4}, 24 + 12);
  EXPECT_EQ(way.frames[index_of(FrameType::ping)], 7u);
  EXPECT_EQ(way.frames[0], 24u + 5u);
  EXPECT_EQ(way.total(), 36u);
}

// Ten robots that all hear each other and have nothing to say. IP, UDP and a session's longer header are counted in.
TEST(Idle, ATeamOfTenNeedsLessThan300BytesASecondARobot) {
  sim::SimNet net(7, {});
  net.add_team(10, sim::complete(10));
  for (std::size_t i = 0; i < 10; ++i) net.append(i, 0, 100);
  ASSERT_TRUE(net.run_until([&] { return net.equal(); }, 20s));
  net.run_for(60s);
  const auto sent = [&] {
    std::uint64_t bytes = 0;
    for (std::size_t i = 0; i < 10; ++i)
      bytes += net.node(i).counters().bytes_sent + (28 + 8) * net.node(i).counters().datagrams_sent;
    return bytes;
  };
  const std::uint64_t before = sent();
  net.run_for(600s);
  const double each = static_cast<double>(sent() - before) / (600 * 10);
  std::printf("an idle robot of ten sends %.0f bytes a second\n", each);
  EXPECT_LE(each, 300);
  EXPECT_GE(each, 50) << "and is still heard";
  for (std::size_t i = 0; i < 10; ++i) EXPECT_EQ(net.node(i).counters().neighbours_lost, 0u);
}

}  // namespace
}  // namespace onemap::comms
