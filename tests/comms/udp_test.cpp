#include "comms/udp/udp_port.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <functional>
#include <thread>

#include "comms/memory_store.hpp"
#include "comms/node.hpp"
#include "sim_net.hpp"

namespace onemap::comms {
namespace {
using namespace std::chrono_literals;

Instant now() {
  return Instant(std::chrono::duration_cast<Duration>(std::chrono::steady_clock::now().time_since_epoch()));
}
const Endpoint kAnyPort = Endpoint::ipv4(127, 0, 0, 1, 0);

TEST(EndpointText, RoundTrips) {
  for (const char* text : {"127.0.0.1:7400", "0.0.0.0:0", "255.1.2.3:65535", "[::1]:7400", "[fe80::1:2]:1"}) {
    const auto endpoint = parse_endpoint(text);
    ASSERT_TRUE(endpoint.ok()) << endpoint.error().text();
    EXPECT_EQ(to_string(*endpoint), text);
  }
  EXPECT_EQ(*parse_endpoint("127.0.0.1:7400"), Endpoint::ipv4(127, 0, 0, 1, 7400));
}

TEST(EndpointText, ErrorsSayWhatIsWrong) {
  const auto reason = [](const char* text) {
    const auto endpoint = parse_endpoint(text);
    return endpoint.ok() ? "accepted" : endpoint.error().text();
  };
  EXPECT_NE(reason("127.0.0.1").find("no port"), std::string::npos);
  EXPECT_NE(reason("127.0.0.1").find("127.0.0.1"), std::string::npos);
  for (const char* text : {"127.0.0.1:", "127.0.0.1:65536", "127.0.0.1:-1", "127.0.0.1:7x", "127.0.0.1: 7"})
    EXPECT_NE(reason(text).find("is not a number from 0 to 65535"), std::string::npos) << text;
  for (const char* text : {"localhost:1", ":1", "127.0.0:1", "[127.0.0.1]:1", "[]:1", "1.2.3.256:1"})
    EXPECT_NE(reason(text).find("is not a numeric IPv"), std::string::npos) << text;
  EXPECT_NE(reason("::1:7400").find("brackets"), std::string::npos);
}

TEST(UdpPort, CarriesDatagramsAndWakes) {
  auto a = UdpPort::open({.listen = kAnyPort, .group = {}}), b = UdpPort::open({.listen = kAnyPort, .group = {}});
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_NE((*a)->local().port, 0);
  OutgoingDatagram out;
  out.to = (*b)->local();
  IncomingDatagram in;
  EXPECT_FALSE((*b)->receive(in));
  for (std::size_t k = 1; k <= 40; ++k) {
    out.size = k * 30;
    out.buffer.fill(static_cast<std::uint8_t>(k));
    ASSERT_TRUE((*a)->send(out));
  }
  for (std::size_t k = 1; k <= 40; ++k) {
    ASSERT_TRUE((*b)->wait(1s));
    ASSERT_TRUE((*b)->receive(in));
    EXPECT_EQ(in.from, (*a)->local());
    ASSERT_EQ(in.size, k * 30);
    EXPECT_EQ(in.buffer[in.size - 1], k);
  }
  EXPECT_FALSE((*b)->receive(in));
  const auto start = std::chrono::steady_clock::now();
  EXPECT_FALSE((*b)->wait(20ms));
  EXPECT_GE(std::chrono::steady_clock::now() - start, 19ms);
  std::thread waker([&] {
    std::this_thread::sleep_for(20ms);
    (*b)->wake();
  });
  EXPECT_FALSE((*b)->wait(30s));
  EXPECT_LT(std::chrono::steady_clock::now() - start, 10s);
  waker.join();
  EXPECT_EQ((*b)->counters().received, 40u);
}

TEST(UdpPort, SaysWhyItCannotListen) {
  auto first = UdpPort::open({.listen = kAnyPort, .group = {}});
  ASSERT_TRUE(first.ok());
  const auto second = UdpPort::open({.listen = (*first)->local(), .group = {}});
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().place, to_string((*first)->local()));
  EXPECT_NE(second.error().reason.find("in use"), std::string::npos);
  EXPECT_FALSE(UdpPort::open({.listen = kAnyPort, .group = Endpoint::ipv4(10, 0, 0, 1, 7400)}).ok());
}

// Real nodes on real sockets, each turned by hand.
struct Robot {
  std::unique_ptr<UdpPort> port;
  MemoryStore store{64u << 20};
  std::unique_ptr<Node> node;
  void turn() {
    IncomingDatagram in;
    while (port->receive(in)) node->on_datagram(now(), in.from, in.bytes());
    if (now() >= node->next_deadline()) node->on_timer(now());
    OutgoingDatagram out;
    while (node->next_outgoing(out)) port->send(out);
  }
};

bool turn_until(std::vector<Robot>& robots, const std::function<bool()>& done, Duration limit) {
  const Instant end = now() + limit;
  while (!done()) {
    if (now() > end) return false;
    for (Robot& robot : robots) robot.turn();
    robots.front().port->wait(200us);
  }
  return true;
}

TEST(UdpPort, LineOfThreeOnLoopback) {
  std::vector<Robot> robots(3);
  for (Robot& robot : robots) {
    auto port = UdpPort::open({.listen = kAnyPort, .group = {}});
    ASSERT_TRUE(port.ok());
    robot.port = std::move(*port);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    NodeConfig config{.self = sim::numbered("robot", i), .peers = {}, .group = {}};
    config.bytes_per_second = 20'000'000;
    config.identity = sim::identity_of(config.self);
    if (i > 0) config.peers = {robots[i - 1].port->local()};  // only one side needs to know the other
    robots[i].node = std::make_unique<Node>(config, robots[i].store);
    for (int k = 0; k < 3; ++k) {
      ASSERT_TRUE(robots[i].node->append(now(), 1, 1, std::vector<std::uint8_t>(500, 1)));
      ASSERT_TRUE(robots[i].node->append(now(), 3, 4,
                                         std::vector<std::uint8_t>(kMaxRecordBytes, static_cast<std::uint8_t>(i))));
    }
  }
  const auto equal = [&] {
    for (const Robot& robot : robots)
      if (robot.node->frontier().size() != 6 || robot.node->frontier_digest() != robots[0].node->frontier_digest())
        return false;
    return true;
  };
  const Instant start = now();
  ASSERT_TRUE(turn_until(robots, equal, 60s));
  printf("line of three over loopback, 9 MiB: %.2f s\n", to_seconds(now() - start));
  EXPECT_EQ(robots[2].store.bytes(), robots[0].store.bytes());
  EXPECT_EQ(robots[2].node->neighbours().size(), 1u);
  EXPECT_EQ(robots[2].node->hops({{RobotId::from_name("robot0"), 3, 1}, 2}), 2);
  ASSERT_TRUE(turn_until(
      robots, [&] { return sim::agrees(*robots[0].node, 3, 0) && sim::agrees(*robots[2].node, 3, 0); }, 30s));
}

TEST(UdpPort, AFloodOfUnicastDoesNotSilenceTheGroup) {
  const Endpoint group = Endpoint::ipv4(239, 77, 1, 2, 7478);
  auto hearer = UdpPort::open({.listen = kAnyPort, .group = group});
  auto speaker = UdpPort::open({.listen = kAnyPort, .group = group});
  if (!hearer.ok() || !speaker.ok()) GTEST_SKIP() << "no multicast on loopback here";
  OutgoingDatagram out;
  out.size = 10;
  out.buffer.fill(1);
  const auto flood = [&](int datagrams) {
    out.to = (*hearer)->local();
    out.buffer[0] = 1;
    for (int k = 0; k < datagrams; ++k) (*speaker)->send(out);
  };
  flood(200);
  out.to = group;
  out.buffer[0] = 2;
  ASSERT_TRUE((*speaker)->send(out));
  IncomingDatagram in;
  int before = 0;
  while ((*hearer)->wait(1s) && (*hearer)->receive(in) && in.buffer[0] != 2) {
    flood(1);
    ASSERT_LT(++before, 100) << "the group's datagram waits behind all others";
  }
  if (in.buffer[0] != 2) GTEST_SKIP() << "multicast does not loop back here";
}

TEST(UdpPort, RobotsFindEachOtherByMulticast) {
  const Endpoint group = Endpoint::ipv4(239, 77, 1, 1, 7477);
  std::vector<Robot> robots(2);
  for (std::size_t i = 0; i < 2; ++i) {
    auto port = UdpPort::open({.listen = kAnyPort, .group = group});
    if (!port.ok()) GTEST_SKIP() << "no multicast on loopback here: " << port.error().text();
    robots[i].port = std::move(*port);
    NodeConfig config{.self = sim::numbered("robot", i), .peers = {}, .group = group};
    config.identity = sim::identity_of(config.self);
    robots[i].node = std::make_unique<Node>(config, robots[i].store);
    ASSERT_TRUE(robots[i].node->append(now(), 1, 1, {1, 2, 3}));
  }
  ASSERT_TRUE(turn_until(
      robots, [&] { return sim::agrees(*robots[0].node, 2, 0) && sim::agrees(*robots[1].node, 2, 0); }, 20s));
  EXPECT_GE(robots[0].node->counters().of(Refusal::own_echo), 1u);
}

}  // namespace
}  // namespace onemap::comms
