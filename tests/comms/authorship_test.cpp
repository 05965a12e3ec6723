// Nobody else writes for a robot; and what a robot's neighbours remember of its former life.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "alone_node.hpp"

namespace onemap::comms {
namespace {
using namespace std::chrono_literals;
using sim::Alone;
using sim::greeting;
using sim::kStranger;
using sim::SimNet;

const RobotId kSelf = RobotId::from_name("self"), kFriend = RobotId::from_name("friend");
const Endpoint kLiar = Endpoint::ipv4(127, 0, 0, 2, 9999), kThird = Endpoint::ipv4(127, 0, 0, 3, 9999);

// What wipe does: records in our own name, of a later life.
TEST(Authorship, LaterLivesOfOurselvesAreNotTaken) {
  Alone alone;
  alone.befriend();
  std::uint32_t counter = 1;
  for (const std::uint64_t life : {Alone::kLife + 1, std::uint64_t{1} << 62, ~std::uint64_t{0}}) {
    const LogId log{kSelf, 0, life};
    const wire::HaveEntry entry{log, 1};
    alone.hear_frames(5, ++counter, [&](auto& out) { out.have(entry_digest(log, 1), {&entry, 1}); });
    EXPECT_FALSE(sim::first<wire::Want>(alone.sent())) << "it is not asked for";
    alone.hear_record(5, ++counter, sim::SignedLogs().next(log, 0, {}));
    const RobotStatus status{kSelf, life, 1, 2, 3, 1};
    alone.hear_frames(5, ++counter, [&](auto& out) { out.status({&status, 1}); });
  }
  EXPECT_TRUE(alone.node.frontier().empty());
  EXPECT_EQ(alone.node.records_missing(), 0u);
  EXPECT_EQ(alone.node.counters().of(Refusal::later_life), 5u);
  EXPECT_EQ(alone.node.counters().of(Refusal::bad_incarnation), 1u);
  EXPECT_EQ(alone.node.counters().of(Refusal::data_unasked), 3u);
  EXPECT_FALSE(alone.node.outlived()) << "an offer is no proof";
  EXPECT_EQ(alone.node.team().at(kSelf).incarnation, Alone::kLife);
}

TEST(Authorship, FormerLivesOfOurselvesComeBack) {
  Alone alone;
  alone.befriend();
  const LogId log{kSelf, 1, 12};
  const wire::HaveEntry entry{log, 1};
  alone.hear_frames(5, 2, [&](auto& out) { out.have(entry_digest(log, 1), {&entry, 1}); });
  EXPECT_TRUE(sim::first<wire::Want>(alone.sent()));
  alone.hear_record(5, 3, sim::SignedLogs().next(log, 0, {}));
  EXPECT_EQ(alone.node.frontier(), (VersionVector{{log, 1}}));
}

TEST(Authorship, WhatContradictsANeighboursOwnGreetingIsRefusedAndItIsTold) {
  Alone alone;
  alone.befriend("friend", 5);
  alone.befriend("liar", 9, kLiar);
  const LogId forged{kFriend, 0, 8}, own{kFriend, 0, 5}, former{kFriend, 0, 4};
  const std::vector<wire::HaveEntry> entries{{forged, 1}, {own, 1}, {former, 1}};
  alone.hear_frames(
      9, 2, [&](auto& out) { out.have(1, entries); }, kLiar);
  EXPECT_EQ(alone.node.counters().of(Refusal::contradicts_author), 1u);
  EXPECT_EQ(alone.node.records_missing(), 2u) << "its present and its former life travel";
  const auto told = sim::first<wire::LaterLife>(alone.sent_within(100ms));
  ASSERT_TRUE(told);
  EXPECT_EQ(told->second, (wire::LaterLife{kFriend, 8}));
  // Not again and again.
  for (std::uint32_t k = 3; k < 20; ++k)
    alone.hear_frames(
        9, k, [&](auto& out) { out.have(1, entries); }, kLiar);
  EXPECT_FALSE(sim::first<wire::LaterLife>(alone.sent_within(100ms)));
}

// A neighbour told of a later life while the author was away, and has no reason to tell it once more: it is asked.
TEST(Authorship, AnAuthorThatComesHearsOfTheLaterLifeThatAnotherToldOf) {
  Alone alone;
  alone.befriend("other", 9, kLiar);
  const LogId later{kFriend, 1, 8};
  const wire::HaveEntry entry{later, 1};
  const auto tell = [&](std::uint32_t counter) {
    alone.hear_frames(
        9, counter,
        [&](auto& out) {
          out.have(entry_digest(later, 1), {&entry, 1});
        },
        kLiar);
  };
  tell(2);
  EXPECT_EQ(alone.node.records_missing(), 1u);
  alone.befriend("friend", 5);
  EXPECT_EQ(alone.node.records_missing(), 0u);
  EXPECT_FALSE(sim::first<wire::HaveRequest>(alone.sent_within(100ms, kLiar)));
  alone.hear_frames(
      9, 3,
      [&](auto& out) {
        out.beacon({RobotId::from_name("other"), entry_digest(later, 1), 0, 2, 0});
      },
      kLiar);
  EXPECT_TRUE(sim::first<wire::HaveRequest>(alone.sent_within(200ms, kLiar)));
  tell(4);
  const auto told = sim::first<wire::LaterLife>(alone.sent_within(100ms));
  ASSERT_TRUE(told);
  EXPECT_EQ(told->second, (wire::LaterLife{kFriend, 8}));
}

// Asked for while the author was away; then the author comes, and the answer is not taken any more.
TEST(Authorship, TheAuthorsGreetingStopsWhatIsOnItsWay) {
  Alone alone;
  alone.befriend("liar", 9, kLiar);
  const LogId forged{kFriend, 0, 8};
  const wire::HaveEntry entry{forged, 1};
  alone.hear_frames(
      9, 2,
      [&](auto& out) {
        out.have(entry_digest(forged, 1), {&entry, 1});
      },
      kLiar);
  EXPECT_TRUE(sim::first<wire::Want>(alone.sent()));
  EXPECT_EQ(alone.node.records_missing(), 1u);
  alone.befriend("friend", 5);
  EXPECT_EQ(alone.node.records_missing(), 0u) << "it is not waited for any longer";
  for (const NeighbourStatus& neighbour : alone.node.neighbours())
    EXPECT_EQ(neighbour.asked_bytes, 0u) << "nor asked for";
  alone.hear_record(9, 3, sim::SignedLogs().next(forged, 0, {}), kLiar);
  EXPECT_TRUE(alone.node.frontier().empty());
  EXPECT_EQ(alone.node.records_missing(), 0u);
  // The author goes away, and the other one stays: it says what it holds when it is asked.
  for (std::uint32_t k = 4; k < 30; ++k) {
    const bool asked = sim::first<wire::HaveRequest>(alone.sent_within(1s, kLiar)).has_value();
    alone.hear_frames(
        9, k,
        [&](auto& out) {
          out.beacon({RobotId::from_name("liar"), entry_digest(forged, 1), 0, k, 0});
          if (asked) out.have(entry_digest(forged, 1), {&entry, 1});
        },
        kLiar);
  }
  EXPECT_EQ(alone.node.records_missing(), 1u);
}

TEST(Authorship, AFormerLifeIsToldOfTheLaterOne) {
  Alone alone;
  alone.befriend("friend", 50);
  const LogId log{kFriend, 0, 50};
  const wire::HaveEntry entry{log, 1};
  alone.hear_frames(50, 2, [&](auto& out) { out.have(1, {&entry, 1}); });
  EXPECT_TRUE(sim::first<wire::Want>(alone.sent()));
  alone.hear_record(50, 3, sim::SignedLogs().next(log, 0, {}));
  ASSERT_EQ(alone.node.frontier().size(), 1u);
  alone.sent();
  // At the same address, and, when the neighbour is long gone, at another.
  for (const Endpoint& where : {kStranger, kThird}) {
    const auto hello = greeting("friend", 7, 0, 1);
    alone.hear(hello, where);
    std::size_t bytes = 0;
    const auto answers = alone.sent();
    for (const auto& answer : answers) bytes += answer.size;
    EXPECT_LE(bytes, hello.size());
    const auto told = sim::first<wire::LaterLife>(answers);
    ASSERT_TRUE(told);
    EXPECT_EQ(told->first.receiver, 7u);
    EXPECT_EQ(told->second, (wire::LaterLife{kFriend, 50}));
    alone.now += 30s;
    alone.node.on_timer(alone.now);
    alone.sent();
  }
  EXPECT_EQ(alone.node.counters().of(Refusal::former_life), 2u);
}

// Only who was greeted may answer so, and only to the life that greeted.
TEST(Authorship, LaterLifeIsBelievedOfWhomWeGreetedAndWithinBounds) {
  NodeConfig config;
  config.peers = {kThird};
  Alone alone(config);
  const auto tell = [&](const Endpoint& from, std::uint64_t receiver, const RobotId& robot, std::uint64_t life) {
    alone.hear(sim::datagram({wire::DatagramType::unicast, 5, receiver, 1},
                             [&](wire::Encoder& out) {
                               out.later_life({robot, life});
                             }),
               from);
    return alone.node.outlived();
  };
  EXPECT_FALSE(tell(kStranger, Alone::kLife, kSelf, 100)) << "nobody greeted it";
  EXPECT_FALSE(tell(kThird, Alone::kLife - 1, kSelf, 100)) << "it answers another life";
  EXPECT_FALSE(tell(kThird, Alone::kLife, kFriend, 100)) << "it speaks of another robot";
  EXPECT_FALSE(tell(kThird, Alone::kLife, kSelf, Alone::kLife)) << "no later one";
  EXPECT_FALSE(tell(kThird, Alone::kLife, kSelf, std::uint64_t{1} << 63)) << "no life at all";
  EXPECT_EQ(alone.node.counters().of(Refusal::bad_incarnation), 1u);
  EXPECT_EQ(tell(kThird, Alone::kLife, kSelf, 100), 100u);
  EXPECT_EQ(tell(kThird, Alone::kLife, kSelf, 90), 100u) << "the greatest counts";
}

// The clock of robot 1 goes back between two lives: it hears of it from its neighbour, and goes on after that.
TEST(Authorship, ASmallerIncarnationIsToldAndTheTeamFormsAgain) {
  for (const double loss : {0.0, 0.2}) {
    SimNet net(31, {.loss = loss});
    NodeConfig config;
    config.incarnation = 1000;
    net.add_team(3, sim::line(3), config);
    for (std::size_t i = 0; i < 3; ++i) net.append(i, 0, 50);
    ASSERT_TRUE(net.run_until([&] { return net.equal(); }, 20s));
    NodeConfig again;
    again.incarnation = 10;
    again.peers = {SimNet::address(0), SimNet::address(2)};
    net.restart(1, again);
    net.append(1, 0, 60);
    ASSERT_TRUE(net.run_until([&] { return net.node(1).outlived().has_value(); }, 20s));
    EXPECT_EQ(*net.node(1).outlived(), 1000u);
    again.incarnation = *net.node(1).outlived() + 1;
    net.restart(1, again);
    const RecordId fresh = net.append(1, 0, 60);
    ASSERT_TRUE(net.run_until([&] { return net.equal() && net.node(0).hops(fresh) && net.node(2).hops(fresh); }, 20s));
    ASSERT_TRUE(net.run_until([&] { return sim::agrees(net.node(0), 3, 0); }, 20s));
    EXPECT_EQ(net.node(1).outlived(), std::nullopt);
  }
}

}  // namespace
}  // namespace onemap::comms
