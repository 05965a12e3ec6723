// What the protocol promises on a link of 20 Mbit/s and 5 ms, in virtual time.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "support/paced_net.hpp"

namespace onemap::comms {
namespace {
using namespace std::chrono_literals;
using paced::PacedNet;

template <class T>
T percentile(std::vector<T> values, double share) {
  if (values.empty()) return T{};
  const auto at = static_cast<std::size_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(at), values.end());
  return values[at];
}

struct Measured {
  double goodput_mbit = 0, queue_p95_ms = 0, pose_p99_ms = 0, pose_loss = 0, wire_per_useful = 0, duplicates = 0;
};

enum class Datagrams { plain, sealed };  // sealed: as a team with a key speaks

Measured saturate(const test::LinkTraits& traits, Duration time, Datagrams datagrams, std::uint64_t seed) {
  PacedNet net(seed);
  for (const std::size_t other : {1u, 0u}) {
    NodeConfig config;
    config.peers = {PacedNet::address(other)};
    config.sealed = datagrams == Datagrams::sealed;
    net.add(config);
  }
  net.route(0, 1, net.link(traits));
  net.route(1, 0, net.link(traits));
  const auto met = [&](std::size_t i) {
    const auto all = net.node(i).neighbours();
    return !all.empty() && all[0].alive;
  };
  do net.run_for(1s);
  while (!met(0) || !met(1));
  std::map<std::uint32_t, Instant> written;
  std::vector<double> pose_ms;
  net[1].applied = [&](const Record& record) {
    if (record.id.log.lane == 1) pose_ms.push_back(1e3 * to_seconds(net.now() - written.at(record.id.seq)));
  };
  net.every(100ms, [&] {  // twice as often as a robot seals keyframes
    written[static_cast<std::uint32_t>(written.size())] = net.now();
    net.append(0, 1, 120);
  });
  net.feed(0, 1, 60'000, 8'000'000);
  net.way(0, 1).keep_queues(true);
  const std::uint64_t wire = net.wire_bytes();
  net.run_for(time);
  const Counters& here = net.node(1).counters();
  Measured out;
  const double useful = static_cast<double>(here.body_bytes_received);
  out.goodput_mbit = useful * 8e-6 / to_seconds(time);
  out.queue_p95_ms = 1e3 * to_seconds(percentile(net.way(0, 1).queues(), 0.95));
  out.pose_p99_ms = percentile(pose_ms, 0.99);
  out.pose_loss = 1.0 - static_cast<double>(pose_ms.size()) / static_cast<double>(written.size());
  out.wire_per_useful = static_cast<double>(net.wire_bytes() - wire) / useful;
  out.duplicates = static_cast<double>(here.duplicate_body_bytes) / useful;
  return out;
}

Measured median_of(const test::LinkTraits& traits, Duration time, Datagrams datagrams) {
  std::vector<Measured> runs;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) runs.push_back(saturate(traits, time, datagrams, seed));
  const auto median = [&](auto member) {
    std::vector<double> values;
    for (const Measured& run : runs) values.push_back(run.*member);
    return percentile(values, 0.5);
  };
  return {median(&Measured::goodput_mbit), median(&Measured::queue_p95_ms),    median(&Measured::pose_p99_ms),
          median(&Measured::pose_loss),    median(&Measured::wire_per_useful), median(&Measured::duplicates)};
}

struct Goal {
  double loss, goodput_mbit;
};

void expect_goals(Datagrams datagrams) {
  for (const Goal goal : {Goal{0.0, 17.8}, {0.01, 17.7}, {0.05, 17.0}, {0.10, 16.1}, {0.20, 14.3}, {0.30, 12.5}}) {
    test::LinkTraits traits;
    traits.loss = goal.loss;
    const Measured got = median_of(traits, 20s, datagrams);
    std::printf(
        "loss %2.0f %%: %.2f Mbit/s, queue p95 %.1f ms, pose p99 %.1f ms, wire / useful %.3f, duplicates %.2f %%\n",
        100 * goal.loss, got.goodput_mbit, got.queue_p95_ms, got.pose_p99_ms, got.wire_per_useful,
        100 * got.duplicates);
    EXPECT_GE(got.goodput_mbit, goal.goodput_mbit) << goal.loss;
    EXPECT_LE(got.queue_p95_ms, 30.0) << goal.loss;
    EXPECT_LE(got.wire_per_useful, 1.12 / (1.0 - goal.loss)) << goal.loss;
    EXPECT_LE(got.duplicates, 0.01) << goal.loss;
    if (goal.loss <= 0.10) {
      EXPECT_LE(got.pose_p99_ms, 50.0) << goal.loss;
    }
    EXPECT_LE(got.pose_loss, 0.01) << "poses that are not there yet";
  }
}

TEST(Goals, ALossyLinkIsFilledAndItsQueueIsShort) { expect_goals(Datagrams::sealed); }
TEST(Goals, AndSoInPlainDatagrams) { expect_goals(Datagrams::plain); }

}  // namespace
}  // namespace onemap::comms
