// How the rate behaves on other links than the one of the goals, in virtual time.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <vector>

#include "support/paced_net.hpp"

namespace onemap::comms {
namespace {
using namespace std::chrono_literals;
using paced::PacedNet;
using test::LinkTraits;

// Pairs of robots, each with data for the other one's whole life; all pairs share one link there and one back.
struct Pairs {
  PacedNet net;
  std::size_t pairs;
  PacedNet::Link there, back;
  Pairs(std::uint64_t seed, std::size_t count, const LinkTraits& traits)
      : net(seed), pairs(count), there(net.link(traits)), back(net.link(traits)) {
    for (std::size_t i = 0; i < 2 * pairs; ++i) {
      NodeConfig config;
      config.peers = {PacedNet::address(i ^ 1u)};
      net.add(config);
      net.route(i, i ^ 1u, i % 2 == 0 ? there : back);
    }
    net.run_for(1s);
    there->keep_queues(true);
  }
  void feed(std::size_t pair) { net.feed(2 * pair, 2 * pair + 1, 60'000, 6'000'000); }
  // Mbit/s of each pair's bodies over this time.
  std::vector<double> goodput(Duration time) {
    std::vector<double> before(pairs), out(pairs);
    for (std::size_t i = 0; i < pairs; ++i) before[i] = received(i);
    there->keep_queues(true);
    net.run_for(time);
    for (std::size_t i = 0; i < pairs; ++i) out[i] = (received(i) - before[i]) * 8e-6 / to_seconds(time);
    return out;
  }
  double received(std::size_t pair) {
    return static_cast<double>(net.node(2 * pair + 1).counters().body_bytes_received);
  }
  double queue_ms(double share) const {
    auto queues = there->queues();
    if (queues.empty()) return 0.0;
    std::sort(queues.begin(), queues.end());
    return 1e3 * to_seconds(queues[static_cast<std::size_t>(share * static_cast<double>(queues.size() - 1))]);
  }
  double rate_mbit(std::size_t pair) { return net.node(2 * pair).neighbours().at(0).rate * 8e-6; }
};

double jain(const std::vector<double>& shares) {
  double sum = 0, squares = 0;
  for (double share : shares) sum += share, squares += share * share;
  return sum * sum / (static_cast<double>(shares.size()) * squares);
}

double alone(const LinkTraits& traits, Duration settle, Duration time, double* queue_p95_ms = nullptr) {
  Pairs one(1, 1, traits);
  one.feed(0);
  one.net.run_for(settle);
  const double got = one.goodput(time)[0];
  if (queue_p95_ms != nullptr) *queue_p95_ms = one.queue_ms(0.95);
  return got;
}

TEST(RateControl, LinksOfManyKindsAreFilled) {
  struct Case {
    const char* name;
    LinkTraits traits;
    double least_mbit, queue_p95_ms;
  };
  std::vector<Case> cases;
  const auto add = [&](const char* name, double mbit, Duration delay, double least, double queue) -> LinkTraits& {
    LinkTraits traits;
    traits.bits_per_second = 1e6 * mbit;
    traits.delay = delay;
    cases.push_back({name, traits, least, queue});
    return cases.back().traits;
  };
  add("2 Mbit/s, 5 ms", 2, 5ms, 1.7, 60);
  add("100 Mbit/s, 20 ms", 100, 20ms, 85, 30);
  add("100 Mbit/s, 1 ms", 100, 1ms, 85, 30);
  add("20 Mbit/s, 100 ms", 20, 100ms, 16, 40);
  add("20 Mbit/s, 5 ms, jitter 5 ms", 20, 5ms, 16.5, 30).jitter = 5ms;
  {
    LinkTraits& bursts = add("20 Mbit/s, 5 ms, bursts of loss", 20, 5ms, 15, 30);
    bursts.burst = 0.005;
  }
  add("20 Mbit/s, 5 ms, 2 % reordered", 20, 5ms, 16.5, 30).reordering = 0.02;
  add("20 Mbit/s, 5 ms, 5 % twice", 20, 5ms, 17, 30).duplication = 0.05;
  add("20 Mbit/s, 5 ms, a queue of 8 packets", 20, 5ms, 13, 30).queue_bytes = 8 * 1240;
  add("20 Mbit/s, 5 ms, a queue of 25 packets", 20, 5ms, 15, 30).queue_bytes = 25 * 1240;
  for (const Case& one : cases) {
    double queue = 0;
    const double got = alone(one.traits, 2s, 6s, &queue);
    std::printf("%-40s %.2f Mbit/s, queue p95 %.1f ms\n", one.name, got, queue);
    EXPECT_GE(got, one.least_mbit) << one.name;
    EXPECT_LE(queue, one.queue_p95_ms) << one.name;
  }
}

TEST(RateControl, FollowsALinkThatChanges) {
  LinkTraits traits;
  Pairs one(2, 1, traits);
  one.feed(0);
  one.net.run_for(2s);
  for (const double mbit : {5.0, 40.0, 10.0, 20.0}) {
    traits.bits_per_second = 1e6 * mbit;
    one.there->set(traits);
    one.net.run_for(1s);
    const double got = one.goodput(2s)[0];
    std::printf("%.0f Mbit/s: %.2f, queue p95 %.1f ms\n", mbit, got, one.queue_ms(0.95));
    EXPECT_GE(got, 0.85 * mbit);
    EXPECT_LE(one.queue_ms(0.95), 45.0) << mbit;
  }
}

TEST(RateControl, LossThatComesLaterDoesNotSlowIt) {
  LinkTraits traits;
  Pairs one(3, 1, traits);
  one.feed(0);
  one.net.run_for(3s);
  for (const double loss : {0.3, 0.0, 0.15}) {
    traits.loss = loss;
    one.there->set(traits);
    one.net.run_for(2s);
    const double got = one.goodput(3s)[0];
    std::printf("loss %.2f: %.2f\n", loss, got);
    EXPECT_GE(got, 0.95 * 18.3 * (1.0 - loss)) << loss;
  }
}

// A keyframe now and then, and beacons and wants between them: that little was sent says nothing of the way.
TEST(RateControl, WhoHasLittleToSendStaysFast) {
  for (const double mbit : {20.0, 1000.0}) {
    LinkTraits traits;
    traits.bits_per_second = 1e6 * mbit;
    traits.delay = 1ms;
    traits.jitter = 1ms;
    Pairs one(5, 1, traits);
    for (std::size_t robot : {0u, 1u}) {
      one.net.every(300ms + 37ms * robot, [&one, robot] { one.net.append(robot, 2, 20'000); });
      one.net.every(1100ms + 37ms * robot, [&one, robot] { one.net.append(robot, 1, 500); });
      one.net.every(2900ms + 37ms * robot, [&one, robot] { one.net.append(robot, 3, 130'000); });
    }
    one.net.run_for(3s);
    double least = one.rate_mbit(0);
    one.net.every(100ms, [&] { least = std::min(least, one.rate_mbit(0)); });
    one.net.run_for(60s);
    std::printf("%.0f Mbit/s, of which it uses 1: a rate of at least %.1f\n", mbit, least);
    EXPECT_GE(least, 0.4 * std::min(mbit, 20.0));
  }
}

TEST(RateControl, TwoShare) {
  for (const Duration later : {0ms, 700ms, 6000ms}) {
    LinkTraits traits;
    Pairs two(4, 2, traits);
    two.feed(0);
    two.net.run_for(later);
    two.feed(1);
    two.net.run_for(12s);
    const auto shares = two.goodput(20s);
    std::printf("second %.1f s later: %.2f and %.2f, Jain %.3f, queue p95 %.1f ms\n", to_seconds(later), shares[0],
                shares[1], jain(shares), two.queue_ms(0.95));
    EXPECT_GE(jain(shares), 0.9);
    EXPECT_GE(shares[0] + shares[1], 16.5);
  }
}

}  // namespace
}  // namespace onemap::comms
