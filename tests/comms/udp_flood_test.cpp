// A robot of a team with a key on a real socket, while strangers send what they like (tests/bench/comms_flood_bench.cpp
// does it at 100,000 a second).
#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <numeric>

#include "comms/memory_store.hpp"
#include "comms/udp/udp_port.hpp"
#include "support/garbage.hpp"
#include "support/guarded.hpp"
#include "support/signed_logs.hpp"

namespace onemap::comms::sim {
namespace {

using namespace std::chrono_literals;

Instant clock_now() {
  return Instant(std::chrono::duration_cast<Duration>(std::chrono::steady_clock::now().time_since_epoch()));
}

std::unique_ptr<UdpPort> any_port() {
  auto port = UdpPort::open({.listen = Endpoint::ipv4(127, 0, 0, 1, 0), .group = {}});
  return port ? std::move(*port) : nullptr;
}

// Turned by hand.
struct SocketRobot {
  std::unique_ptr<UdpPort> port = any_port();
  MemoryStore store{64u << 20};
  Pins pins;
  std::vector<std::string> key_log;
  Node node;
  Guard guard;

  static NodeConfig node_config(const std::string& name, std::vector<Endpoint> peers) {
    NodeConfig config{.self = RobotId::from_name(name), .peers = std::move(peers), .group = {}};
    config.identity = identity_of(config.self);
    config.sealed = true;
    return config;
  }
  GuardConfig guard_config(const std::string& name) {
    const RobotId self = RobotId::from_name(name);
    GuardConfig config{self, 1, {}, kTeam, identity_of(self), {}, {}, 64};
    config.random = [random = test::Random(self.bytes[0])](std::span<std::uint8_t> bytes) mutable {
      for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.next() >> 56);
    };
    config.key_log = [this](std::string_view line) { key_log.emplace_back(line); };
    return config;
  }
  SocketRobot(const std::string& name, std::vector<Endpoint> peers)
      : node(node_config(name, std::move(peers)), store), guard(guard_config(name), node, pins) {}

  void turn() {
    IncomingDatagram in;
    while (port->receive(in)) guard.on_datagram(clock_now(), in.from, in.bytes());
    if (clock_now() >= guard.next_deadline()) guard.on_timer(clock_now());
    OutgoingDatagram out;
    while (guard.next_outgoing(out)) port->send(out);
  }
  // Datagrams; parts of good ones aside.
  std::uint64_t refused() const {
    const auto counters = guard.counters();
    return std::accumulate(counters.refused.begin(), counters.refused.begin() + static_cast<int>(Refusal::logs_full),
                           std::uint64_t{0});
  }
};

bool turn_both_until(SocketRobot& a, SocketRobot& b, const std::function<bool()>& done) {
  const Instant end = clock_now() + 60s;
  for (; !done(); a.port->wait(200us)) {
    if (clock_now() > end) return false;
    a.turn();
    b.turn();
  }
  return true;
}

TEST(UdpFlood, GarbageGetsNoWordAndEachOfItIsCounted) {
  SocketRobot robot("robot", {});
  const auto stranger = any_port();
  ASSERT_TRUE(robot.port && stranger);
  SocketRobot friendly("friendly", {robot.port->local()});
  ASSERT_TRUE(turn_both_until(robot, friendly, [&] {
    return robot.guard.sessions() == 1 && friendly.guard.sessions() == 1 && !robot.node.neighbours().empty();
  }));
  Garbage garbage(kTeam, 1);
  for (const std::string& line : robot.key_log) garbage.overhear(line);
  ASSERT_EQ(garbage.sessions(), 2u) << "one, by both names";
  const std::uint64_t before = robot.refused();
  std::uint64_t sent = 0;
  OutgoingDatagram out;
  out.to = robot.port->local();
  for (std::uint32_t round = 0; round < 200; ++round) {  // a few at a time: the socket's buffer holds them
    ASSERT_TRUE(friendly.node.append(clock_now(), 3, 1, std::vector<std::uint8_t>(5000, 7)));
    for (const auto& [kind, name] : Garbage::kKinds) {
      const Datagram bytes = garbage.make(kind);
      out.size = bytes.size();
      std::ranges::copy(bytes, out.buffer.begin());
      ASSERT_TRUE(stranger->send(out)) << name;
      ++sent;
    }
    robot.turn();
    friendly.turn();
  }
  const auto equal = [&] { return robot.node.frontier_digest() == friendly.node.frontier_digest(); };
  ASSERT_TRUE(turn_both_until(robot, friendly, equal));
  EXPECT_EQ(robot.refused(), before + sent);
  for (const Refusal reason : {Refusal::bad_magic, Refusal::not_sealed, Refusal::bad_size, Refusal::bad_cookie,
                               Refusal::bad_mac, Refusal::bad_seal, Refusal::unknown_session})
    EXPECT_GE(robot.guard.counters().of(reason), 200u) << name(reason);
  IncomingDatagram answer;
  EXPECT_FALSE(stranger->wait(50ms) && stranger->receive(answer));
  EXPECT_EQ(robot.guard.sessions(), 1u);
  EXPECT_EQ(robot.node.neighbours().size(), 1u);
}

}  // namespace
}  // namespace onemap::comms::sim
