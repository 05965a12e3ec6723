// The team's talks, alone and in whole teams by the simulator.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "consensus/talks.hpp"
#include "sim/sim_net.hpp"
#include "support/alone_node.hpp"

namespace onemap::comms {
namespace {
using namespace std::chrono_literals;
using sim::Alone;
using sim::SimNet;

constexpr auto kClock = static_cast<std::size_t>(Scalar::clock_offset);
constexpr auto kLight = static_cast<std::size_t>(Scalar::brightness);
constexpr auto kSize = static_cast<std::size_t>(Scalar::team_size);

double clock_of(std::size_t i) {
  return 1.7e9 + 0.5 * static_cast<double>(i);
}  // wall clock ahead of the monotonic one
double light_of(std::size_t i) { return 80.0 + 20.0 * static_cast<double>(i); }

void bring_all(SimNet& net) {
  for (std::size_t i = 0; i < net.size(); ++i) {
    if (!net.runs(i)) continue;
    net.node(i).bring(net.now(), Scalar::clock_offset, clock_of(i));
    net.node(i).bring(net.now(), Scalar::brightness, light_of(i));
  }
}

bool all_settled(SimNet& net, double robots) {
  for (std::size_t i = 0; i < net.size(); ++i) {
    if (!net.runs(i)) continue;
    const ScalarsView view = net.node(i).scalars();
    if (!view.settled || std::abs(view.values[kSize].agreed - robots) > 0.05) return false;
  }
  return true;
}

TEST(Talks, ATeamAgreesOnItsMeansAndItsSizeInSpiteOfLoss) {
  for (const double loss : {0.0, 0.3}) {
    SimNet net(51, {.loss = loss, .duplication = 0.1, .delay = 10ms, .jitter = 5ms});
    net.add_team(6, sim::ring(6));
    bring_all(net);
    ASSERT_TRUE(net.run_until([&] { return all_settled(net, 6); }, 60s)) << loss;
    for (std::size_t i = 0; i < 6; ++i) {
      const ScalarsView view = net.node(i).scalars();
      EXPECT_NEAR(view.values[kLight].agreed, 130, 0.5);
      EXPECT_EQ(view.values[kLight].own, light_of(i));
      EXPECT_NEAR(view.values[kSize].agreed, 6, 0.05);
      // Delay is not quite known, so a clock that is told over links is a few milliseconds off.
      EXPECT_NEAR(view.values[kClock].own, 0.5 * (static_cast<double>(i) - 2.5), 0.05) << i;
      EXPECT_EQ(view.round_of_talks, net.node(0).scalars().round_of_talks);
    }
  }
}

TEST(Talks, WhoGoesIsNotCountedAnyLongerAndWhoComesIs) {
  SimNet net(52, {.delay = 5ms});
  NodeConfig config;
  config.neighbour_timeout = 5s;
  net.add_team(5, sim::line(5), config);
  bring_all(net);
  ASSERT_TRUE(net.run_until([&] { return all_settled(net, 5); }, 60s));
  net.switch_off(4);
  ASSERT_TRUE(net.run_until([&] { return all_settled(net, 4); }, 60s));
  EXPECT_NEAR(net.node(0).scalars().values[kLight].agreed, 110, 0.5);
  net.switch_on(4, 9);
  bring_all(net);
  ASSERT_TRUE(net.run_until([&] { return all_settled(net, 5); }, 60s));
  EXPECT_NEAR(net.node(0).scalars().values[kLight].agreed, 120, 0.5);
}

TEST(Talks, CostNothingMoreOnceTheyHaveSettled) {
  SimNet net(53, {.delay = 5ms});
  net.add_team(3, sim::line(3));
  bring_all(net);
  ASSERT_TRUE(net.run_until([&] { return all_settled(net, 3); }, 60s));
  net.run_for(20s);
  const auto exchanges = net.node(1).scalars().exchanges;
  const auto told = net.node(1).counters().sent(FrameType::mass);
  net.run_for(60s);
  bring_all(net);
  EXPECT_EQ(net.node(1).scalars().exchanges, exchanges);
  EXPECT_LT(net.node(1).counters().sent(FrameType::mass) - told, 60u) << "with beacons, to two neighbours";
  net.node(2).bring(net.now(), Scalar::brightness, 200);
  net.run_for(20s);
  EXPECT_NEAR(net.node(0).scalars().values[kLight].agreed, (80.0 + 100 + 200) / 3, 0.5) << "it got brighter there";
}

TEST(Talks, ARobotAloneAgreesWithItself) {
  Talks talks(RobotId::from_name("a"), 1);
  talks.bring(Instant(1s), Scalar::brightness, 50);
  EXPECT_EQ(talks.next(), Instant::max()) << "nobody is there to talk with";
  EXPECT_FALSE(talks.view().values[kLight].known);
  talks.team_changed(Instant(1s));
  EXPECT_TRUE(talks.exchange(Instant(1s), {}));
  EXPECT_EQ(talks.view().values[kLight].agreed, 50);
  EXPECT_EQ(talks.view().values[kSize].agreed, 1);
}

wire::Mass mass_of(std::uint64_t round, double y) {
  wire::Mass mass;
  mass.round = round, mass.neighbours = 1, mass.has_amounts = true;
  for (comms::Mass& given : mass.given) given = {y, 0.25};
  return mass;
}

TEST(Talks, WhatNoHonestRobotSaysIsRefusedAndCounted) {
  Alone alone;
  alone.befriend();
  std::uint32_t counter = 1;
  const auto say = [&](const wire::Mass& mass) {
    alone.hear_frames(5, ++counter, [&](wire::Encoder& out) { out.mass(mass); });
    return alone.node.counters().of(Refusal::bad_mass);
  };
  alone.node.bring(alone.now, Scalar::brightness, 100);
  EXPECT_EQ(say(mass_of(1u << 24, 5)), 0u);
  EXPECT_EQ(say(mass_of(1u << 24, std::numeric_limits<double>::quiet_NaN())), 1u);
  EXPECT_EQ(say(mass_of(1u << 24, 1e200)), 2u);
  EXPECT_EQ(say(mass_of(0xFFFFFFFFFFFFFFFF, 5)), 3u) << "a round that nobody can have come to";
  wire::Mass late = mass_of(1u << 24, 5);
  late.clock_ns = std::numeric_limits<std::int64_t>::min();
  EXPECT_EQ(say(late), 4u);
  for (const ScalarValue& value : alone.node.scalars().values) EXPECT_TRUE(std::isfinite(value.own));
}

// Both ways: what comes from there, and what the neighbour says that comes from here.
TEST(LinkQuality, IsKnownBothWays) {
  SimNet net(54, {.delay = 5ms});
  net.add_team(2, sim::line(2));
  net.run_for(20s);
  const NeighbourStatus good = net.node(0).neighbours().at(0);
  EXPECT_EQ(good.loss, 0.0);
  EXPECT_NEAR(good.loss_there, 0.0, 1e-3);
  EXPECT_NEAR(good.etx(), 1.0, 0.01);
  net.model().loss = 0.3;
  for (int k = 0; k < 60; ++k) net.append(0, 3, 60'000), net.append(1, 3, 60'000), net.run_for(1s);
  const NeighbourStatus bad = net.node(0).neighbours().at(0);
  EXPECT_NEAR(bad.loss, 0.3, 0.12);
  EXPECT_NEAR(bad.loss_there, 0.3, 0.15);
  EXPECT_NEAR(bad.etx(), 1 / (0.7 * 0.7), 0.8);
}

}  // namespace
}  // namespace onemap::comms
