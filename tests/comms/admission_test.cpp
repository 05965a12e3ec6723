// Who may speak to a node, and who keeps its place.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "alone_node.hpp"

namespace onemap::comms {
namespace {
using namespace std::chrono_literals;
using sim::Alone;
using sim::greeting;
using sim::kStranger;

Endpoint at(std::uint8_t host, std::uint16_t port) { return Endpoint::ipv4(10, 0, 0, host, port); }

const NeighbourStatus& neighbour(const Alone& alone, const Endpoint& endpoint) {
  static NeighbourStatus found;
  for (const auto& status : alone.node.neighbours())
    if (status.endpoint == endpoint) return found = status;
  return found = {};
}

// What spoof.py does, with every number that a forger may know.
TEST(Admission, AForgedGreetingEndsNoLink) {
  for (const std::uint64_t receiver : {std::uint64_t{0}, Alone::kLife})
    for (const std::uint64_t life : {std::uint64_t{5}, std::uint64_t{6}, (std::uint64_t{1} << 63) - 1})
      for (const std::string name : {"friend", "other"})
        for (const std::uint32_t counter : {1u, 2000u, 0xFFFFFFFFu}) {
          if (name == "friend" && life == 5 && receiver == Alone::kLife) continue;  // that is no greeting of another
          Alone alone;
          alone.befriend("friend", 5);
          alone.hear(greeting(name, life, receiver, counter));
          ASSERT_TRUE(neighbour(alone, kStranger).alive);
          ASSERT_EQ(neighbour(alone, kStranger).robot.name(), "friend");
          alone.sent();
          for (std::uint32_t k = 2; k < 20; ++k) {  // the true neighbour is heard as before
            alone.hear_frames(5, k, [&](wire::Encoder& out) { out.ping(k); });
            const auto pong = sim::first<wire::Pong>(alone.sent());
            ASSERT_TRUE(pong) << name << " " << life << " " << counter;
            ASSERT_EQ(pong->second.token, k);
          }
        }
}

TEST(Admission, WhoIsInvalidOrTooLateANumberIsNoNeighbour) {
  Alone alone;
  alone.hear(greeting("friend", std::uint64_t{1} << 63, 0, 1));
  EXPECT_EQ(alone.node.counters().of(Refusal::bad_incarnation), 1u);
  EXPECT_TRUE(alone.node.neighbours().empty());
}

// Nothing is proved about who greeted last from an address where nobody lives.
TEST(Admission, AForgedLaterLifeOfAnAbsentNeighbourIsNoLife) {
  NodeConfig config;
  config.peers = {at(1, 1000)};
  Alone alone(config);
  alone.hear(greeting("friend", std::uint64_t{1} << 62, 0, 1), at(1, 1000));
  alone.hear(greeting("friend", 5, Alone::kLife, 1), at(1, 1000));
  EXPECT_EQ(alone.node.counters().of(Refusal::former_life), 0u);
  EXPECT_TRUE(neighbour(alone, at(1, 1000)).alive);
  EXPECT_EQ(neighbour(alone, at(1, 1000)).incarnation, 5u);
}

// A robot that starts again where its former life is still believed alive: greeting, greeting that names us, token.
TEST(Admission, ACandidateThatRepeatsTheTokenTakesThePlace) {
  Alone alone;
  alone.befriend("friend", 5);
  alone.hear(greeting("friend", 6, 0, 1));
  EXPECT_EQ(alone.node.counters().of(Refusal::candidate), 1u);
  auto answers = alone.sent();
  const auto beacon = sim::first<wire::Beacon>(answers);
  ASSERT_TRUE(beacon);
  EXPECT_EQ(beacon->first.receiver, 6u) << "so that it can name us";
  EXPECT_LE(answers[0].size, greeting("friend", 6, 0, 1).size());
  alone.hear(greeting("friend", 6, Alone::kLife, 2));
  answers = alone.sent();
  const auto ping = sim::first<wire::Ping>(answers);
  ASSERT_TRUE(ping);
  EXPECT_EQ(ping->first.receiver, 6u);
  EXPECT_LE(answers[0].size, greeting("friend", 6, 0, 1).size());
  EXPECT_EQ(neighbour(alone, kStranger).incarnation, 5u) << "not yet";
  alone.hear_frames(6, 3, [&](wire::Encoder& out) { out.pong(ping->second.token ^ 2); });
  EXPECT_EQ(neighbour(alone, kStranger).incarnation, 5u) << "a wrong token";
  alone.hear_frames(6, 4, [&](wire::Encoder& out) { out.pong(ping->second.token); });
  EXPECT_EQ(neighbour(alone, kStranger).incarnation, 6u);
  EXPECT_TRUE(neighbour(alone, kStranger).alive);
}

TEST(Admission, AFloodOfForgedCandidatesDoesNotPushOutOneThatNamedUs) {
  Alone alone;
  alone.befriend("friend", 5);
  alone.hear(greeting("friend", 6, Alone::kLife, 1));
  const auto ping = sim::first<wire::Ping>(alone.sent());
  ASSERT_TRUE(ping);
  for (std::uint64_t k = 0; k < 1000; ++k) alone.hear(greeting("friend", 100 + k, 0, 1));
  alone.hear_frames(6, 3, [&](wire::Encoder& out) { out.pong(ping->second.token); });
  EXPECT_EQ(neighbour(alone, kStranger).incarnation, 6u);
}

// Of a life that is over datagrams may still come, which name us: the next life does not wait until it is forgotten.
TEST(Admission, ALifeThatIsOverDoesNotKeepOutTheNext) {
  Alone alone;
  alone.befriend("friend", 5);
  alone.hear(greeting("friend", 6, Alone::kLife, 1));
  alone.sent();
  alone.hear(greeting("friend", 7, Alone::kLife, 1));
  const auto ping = sim::first<wire::Ping>(alone.sent());
  ASSERT_TRUE(ping);
  EXPECT_EQ(ping->first.receiver, 7u);
  alone.hear_frames(7, 2, [&](wire::Encoder& out) { out.pong(ping->second.token); });
  EXPECT_EQ(neighbour(alone, kStranger).incarnation, 7u);
}

// Who does not know our life may be anybody: its words are not the neighbour's.
TEST(Admission, WhatIsNotProvedIsNotRead) {
  Alone alone;
  alone.befriend("friend", 5);
  const auto say = [&](std::uint64_t receiver, std::uint32_t counter) {
    alone.hear(sim::datagram({wire::DatagramType::unicast, 5, receiver, counter}, [&](wire::Encoder& out) {
      out.beacon({RobotId::from_name("friend"), 7, 8, 9, kStatusFinished});
    }));
    return neighbour(alone, kStranger).flags;
  };
  EXPECT_EQ(say(0, 2), 0);
  EXPECT_EQ(say(Alone::kLife - 1, 3), 0);
  EXPECT_EQ(say(Alone::kLife, 4), kStatusFinished);
}

TEST(Admission, ForgedGreetingsDoNotKeepADeadNeighbourAlive) {
  Alone alone;
  alone.befriend("friend", 5);
  for (std::uint32_t second = 0; second < 21; ++second) {
    alone.now += 1s;
    alone.hear(greeting("friend", 5, 0, second + 2));
    alone.node.on_timer(alone.now);
    alone.sent();
  }
  EXPECT_FALSE(neighbour(alone, kStranger).alive);
  EXPECT_EQ(alone.node.counters().neighbours_lost, 1u);
}

TEST(Admission, StrangersKeepNeitherPeersNorNewcomersOut) {
  NodeConfig config;
  config.peers = {at(1, 1000), at(1, 1001)};
  Alone alone(config);
  // Proved strangers of one address take a quarter of the table, no more; however many only greet, and from wherever.
  for (std::uint16_t k = 0; k < 100; ++k)
    alone.hear(greeting(sim::numbered("s", k).name(), 5, Alone::kLife, 1), at(2, static_cast<std::uint16_t>(2000 + k)));
  EXPECT_EQ(alone.node.neighbours().size(), 8u);
  EXPECT_EQ(alone.node.counters().of(Refusal::address_full), 92u);
  for (std::uint16_t k = 0; k < 2000; ++k)
    alone.hear(greeting(sim::numbered("g", k).name(), 5, 0, 1),
               Endpoint::ipv4(127, 0, static_cast<std::uint8_t>(k >> 8), static_cast<std::uint8_t>(k), 2000));
  EXPECT_LE(alone.node.neighbours().size(), 32u);
  alone.hear(greeting("newcomer", 5, Alone::kLife, 1), at(3, 1000));
  alone.hear(greeting("peer", 5, Alone::kLife, 1), at(1, 1000));
  EXPECT_TRUE(neighbour(alone, at(3, 1000)).alive);
  EXPECT_TRUE(neighbour(alone, at(1, 1000)).alive);
  // Even when proved strangers of many addresses fill the rest, configured peers have their places.
  for (std::uint16_t k = 0; k < 200; ++k)
    alone.hear(greeting(sim::numbered("t", k).name(), 5, Alone::kLife, 1), at(static_cast<std::uint8_t>(k + 4), 3000));
  EXPECT_GT(alone.node.counters().of(Refusal::neighbours_full), 0u);
  alone.hear(greeting("peer2", 5, Alone::kLife, 1), at(1, 1001));
  EXPECT_TRUE(neighbour(alone, at(1, 1001)).alive);
  EXPECT_TRUE(neighbour(alone, at(3, 1000)).alive) << "who is proved stays";
}

TEST(Admission, ConfiguredPeersThatWereNeverHeardAreNamed) {
  NodeConfig config;
  config.peers = {at(1, 1000), at(2, 1000), at(3, 1000)};
  Alone alone(config);
  EXPECT_THAT(alone.node.peers_never_heard(), testing::ElementsAre(at(1, 1000), at(2, 1000), at(3, 1000)));
  alone.hear(greeting("a", 5, 0, 1), at(1, 1000));
  alone.hear(greeting("self", 5, 0, 1), at(2, 1000));  // refused, but heard
  alone.hear(greeting("b", 5, 0, 1), at(9, 1000));
  EXPECT_THAT(alone.node.peers_never_heard(), testing::ElementsAre(at(3, 1000)));
}

TEST(Admission, WhoUsesOurIdIsNamed) {
  Alone alone;
  EXPECT_FALSE(alone.node.id_conflict());
  alone.hear(greeting("self", Alone::kLife, 0, 1), at(1, 1000));
  EXPECT_FALSE(alone.node.id_conflict()) << "our own echo";
  alone.now += 5s;
  alone.hear(greeting("self", 12, 0, 1), at(1, 1000));
  ASSERT_TRUE(alone.node.id_conflict());
  EXPECT_EQ(alone.node.id_conflict()->where, at(1, 1000));
  EXPECT_EQ(alone.node.id_conflict()->incarnation, 12u);
  EXPECT_EQ(alone.node.id_conflict()->when, alone.now);
}

}  // namespace
}  // namespace onemap::comms
