// Teams with a key: real Guards and Nodes over a simulated network, in virtual time.
#include "comms/guard.hpp"

#include <gtest/gtest.h>

#include "session/sealed_wire.hpp"
#include "support/sim_net.hpp"

namespace onemap::comms {
namespace {

using namespace std::chrono_literals;
using sim::LinkModel;
using sim::SimNet;

NodeConfig sealed_config() {
  NodeConfig config;
  config.sealed = true;
  return config;
}

bool all_alive(SimNet& net) {
  for (std::size_t i = 0; i < net.size(); ++i) {
    if (!net[i].on) continue;
    const auto neighbours = net.node(i).neighbours();
    if (neighbours.empty()) return false;
    for (const auto& neighbour : neighbours)
      if (!neighbour.alive) return false;
  }
  return true;
}

TEST(Guard, TwoRobotsWithOneKeyExchangeRecords) {
  SimNet net(1, {});
  net.add_team(2, sim::line(2), sealed_config());
  for (int i = 0; i < 20; ++i) net.append(static_cast<std::size_t>(i % 2), 3, 3000);
  ASSERT_TRUE(net.run_until([&] { return net.equal() && net.node(0).frontier().size() == 2; }, 5s));
  EXPECT_EQ(net[0].guard->sessions(), 1u);
  EXPECT_LE(net.largest_datagram(), kMaxDatagramBytes);
  for (std::size_t i = 0; i < 2; ++i)
    for (const Refusal reason : {Refusal::bad_seal, Refusal::bad_handshake, Refusal::bad_mac, Refusal::bad_frame})
      EXPECT_EQ(net[i].counters().of(reason), 0u) << name(reason);
}

TEST(Guard, NothingOnTheWireIsPlain) {
  SimNet net(2, {});
  net.add_team(2, sim::line(2), sealed_config());
  std::size_t seen = 0, named = 0;
  net.tap = [&](std::size_t, const Endpoint&, std::span<const std::uint8_t> bytes) {
    ++seen;
    EXPECT_EQ(bytes[0], sealed::kMagicAndVersion);
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (text.find("robot") != std::string_view::npos) ++named;
  };
  net.append(0, 1, 500);
  ASSERT_TRUE(net.run_until([&] { return net.equal() && all_alive(net); }, 5s));
  EXPECT_GT(seen, 5u);
  EXPECT_EQ(named, 0u);
}

TEST(Guard, WireBytesStayWithinTwelvePercentOfUsefulOnes) {
  SimNet net(3, {});
  net.add_team(2, sim::line(2), sealed_config());
  ASSERT_TRUE(net.run_until([&] { return all_alive(net); }, 5s));
  const std::uint64_t before = net.bytes_carried();
  for (int i = 0; i < 200; ++i) net.append(0, 3, 60'000);
  ASSERT_TRUE(net.run_until([&] { return net.equal(); }, 60s));
  const double share = static_cast<double>(net.bytes_carried() - before) / static_cast<double>(net.useful_bytes());
  RecordProperty("wire_per_useful", std::to_string(share));
  EXPECT_LE(share, 1.12);
}

TEST(Guard, CountsEveryByteThatItSends) {
  SimNet net(4, {});
  net.add_team(3, sim::complete(3), sealed_config());
  for (std::size_t i = 0; i < 3; ++i) net.append(i, 3, 20'000);
  ASSERT_TRUE(net.run_until([&] { return net.equal(); }, 10s));
  std::uint64_t sent = 0;
  for (std::size_t i = 0; i < 3; ++i) sent += net[i].counters().bytes_sent;
  EXPECT_EQ(sent, net.bytes_carried());
}

TEST(Guard, ATeamConvergesThoughAThirdIsLostAndMuchComesTwice) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    LinkModel model;
    model.loss = 0.3;
    model.duplication = 0.3;
    model.jitter = 20ms;
    SimNet net(seed, model);
    net.add_team(4, sim::ring(4), sealed_config());
    for (std::size_t i = 0; i < 4; ++i)
      for (std::uint8_t lane = 0; lane < 4; ++lane) net.append(i, lane, 5000);
    ASSERT_TRUE(net.run_until([&] { return net.equal() && net.node(0).frontier().size() == 16; }, 30s)) << seed;
  }
}

TEST(Guard, AnotherTeamsRobotIsNotHeardAndHearsNothing) {
  SimNet net(5, {});
  net.add_team(2, sim::line(2), sealed_config());
  net[1].team = TeamKey({9, 9});
  net.restart_node(1);
  std::size_t answers = 0;
  net.tap = [&](std::size_t, const Endpoint&, std::span<const std::uint8_t> bytes) {
    const auto type = static_cast<sealed::Type>(bytes[1]);  // who is configured is greeted, whoever lives there
    if (type != sealed::Type::hello && type != sealed::Type::group) ++answers;
  };
  net.run_for(20s);
  EXPECT_EQ(answers, 0u);
  EXPECT_GT(net[0].counters().of(Refusal::bad_mac), 3u);
  EXPECT_TRUE(net.node(0).neighbours().empty());
}

TEST(Guard, ARobotWithoutTheKeyIsNotHeard) {
  SimNet net(6, {});
  net.add_team(2, sim::line(2), sealed_config());
  net[1].config.sealed = false;
  net.restart_node(1);
  net.run_for(20s);
  EXPECT_GT(net[0].counters().of(Refusal::not_sealed), 3u);
  EXPECT_GT(net.node(1).counters().of(Refusal::bad_version), 1u);
  EXPECT_TRUE(net.node(0).neighbours().empty());
  EXPECT_TRUE(net.node(1).neighbours().empty());
}

TEST(Guard, KeysAreRenewedWithoutLosingADatagram) {
  SimNet net(7, {});
  net.add_team(2, sim::line(2), sealed_config());
  ASSERT_TRUE(net.run_until([&] { return all_alive(net); }, 5s));
  std::size_t hellos = 0;
  net.tap = [&](std::size_t, const Endpoint&, std::span<const std::uint8_t> bytes) {
    if (bytes[1] == static_cast<std::uint8_t>(sealed::Type::hello)) ++hellos;
  };
  for (int second = 0; second < 600; ++second) {
    net.append(0, 3, 20'000);
    net.append(1, 3, 20'000);
    net.run_for(1s);
  }
  EXPECT_GE(hellos, 4u);
  EXPECT_LE(hellos, 6u) << "one side begins";
  ASSERT_TRUE(net.run_until([&] { return net.equal(); }, 5s));
  for (std::size_t i = 0; i < 2; ++i) {
    const Counters c = net[i].counters();
    EXPECT_EQ(c.neighbours_lost, 0u);
    EXPECT_EQ(c.of(Refusal::unknown_session), 0u);
    EXPECT_EQ(c.of(Refusal::bad_seal), 0u);
    EXPECT_EQ(c.fragments_reasked, 0u);
  }
}

TEST(Guard, ARobotThatStartsAnewIsHeardAtOnce) {
  SimNet net(8, {});
  net.add_team(2, sim::line(2), sealed_config());
  net.append(1, 3, 5000);
  ASSERT_TRUE(net.run_until([&] { return net.equal() && all_alive(net); }, 5s));
  NodeConfig again = net[1].config;
  again.incarnation = 2;
  net.restart(1, again);
  ASSERT_TRUE(net.run_until([&] { return net.equal() && net.node(0).frontier().size() == 1; }, 2s));
  EXPECT_EQ(net.node(0).neighbours()[0].incarnation, 2u);
}

// It does not know us: only we can begin, when we notice that it hears nothing.
TEST(Guard, ARobotThatStartsAnewAndGreetsNobodyIsFoundAgain) {
  SimNet net(9, {});
  net.add_team(2, sim::line(2), sealed_config());
  ASSERT_TRUE(net.run_until([&] { return all_alive(net); }, 5s));
  NodeConfig again = net[1].config;
  again.incarnation = 2;
  again.peers.clear();
  net.restart(1, again);
  ASSERT_TRUE(net.run_until([&] { return net.node(0).neighbours()[0].incarnation == 2; }, 20s));
}

TEST(Guard, ALifeThatIsOverIsToldSo) {
  SimNet net(10, {});
  net.add_team(2, sim::line(2), sealed_config());
  net[1].config.incarnation = 5;
  net.restart_node(1);
  net.append(1, 1, 10);
  ASSERT_TRUE(net.run_until([&] { return net.equal() && net.node(0).frontier().size() == 1; }, 5s));
  NodeConfig before = net[1].config;
  before.incarnation = 4;
  net.restart(1, before);
  ASSERT_TRUE(net.run_until([&] { return net.node(1).outlived().has_value(); }, 20s));
  EXPECT_EQ(*net.node(1).outlived(), 5u);
}

TEST(Guard, AfterALongPartitionTheTeamIsOneAgain) {
  SimNet net(11, {});
  net.add_team(2, sim::line(2), sealed_config());
  ASSERT_TRUE(net.run_until([&] { return all_alive(net); }, 5s));
  for (const auto away : {30s, 150s, 400s}) {
    net.cut(0, 1);
    net.append(0, 3, 1000);
    net.run_for(away);
    EXPECT_FALSE(net.equal());
    net.connect(0, 1);
    EXPECT_TRUE(net.run_until([&] { return net.equal(); }, 2s)) << away.count();
  }
}

// One of them did not run while both began a session: then each had one that the other had given up, and spoke in it.
TEST(Guard, ASessionThatOneSideAloneHasIsFoundOut) {
  for (const auto stopped : {2s, 4s, 5s, 6s, 7s}) {
    SimNet net(21, {.delay = 20ms});
    net.add_team(2, sim::line(2), sealed_config());
    net.run_for(33ms);
    net.stop(1, stopped + 364ms);
    net.run_for(stopped + 364ms);
    net.append(0, 3, 1000);
    net.append(1, 3, 1000);
    EXPECT_TRUE(net.run_until([&] { return net.equal(); }, 2s)) << stopped.count();
  }
}

TEST(Guard, ANameBelongsToTheKeyThatProvedItFirst) {
  SimNet net(12, {});
  net.add_team(2, sim::line(2), sealed_config());
  ASSERT_TRUE(net.run_until([&] { return all_alive(net); }, 5s));
  ASSERT_EQ(net[0].pins->all().size(), 1u);
  Pins forged;
  forged.pin(net[1].config.self, Identity(SecretSeed{77}).public_key());
  *net[0].pins = forged;  // as if another had been here under this name
  net.restart_node(0);
  net.run_for(5s);
  EXPECT_FALSE(all_alive(net));
  EXPECT_GE(net[0].counters().of(Refusal::other_key), 1u);
  GuardEvent event;
  ASSERT_TRUE(net[0].guard->next_event(event));
  EXPECT_EQ(event.what, GuardEvent::What::other_key);
  EXPECT_EQ(event.robot, net[1].config.self);
}

// Whoever brings records under a name: they are held against the key that the name belongs to, met now or before.
TEST(Guard, RecordsUnderAProvedNameAreOfItsKey) {
  SimNet net(14, {});
  net.add_team(2, sim::line(2), sealed_config());
  const RobotId other = net[1].config.self;
  ASSERT_FALSE(net.node(0).key_of(other));
  ASSERT_TRUE(net.run_until([&] { return all_alive(net); }, 5s));
  EXPECT_EQ(net.node(0).key_of(other), net[1].config.identity->public_key());
  net.cut(0, 1);
  net.restart_node(0);
  EXPECT_EQ(net.node(0).key_of(other), net[1].config.identity->public_key()) << "it was met before";
}

TEST(Guard, OurNameUsedByAnotherIsAConflict) {
  SimNet net(13, {});
  net.add_team(2, sim::line(2), sealed_config());
  net[1].config.self = net[0].config.self;
  net[1].config.incarnation = 3;
  net.restart_node(1);
  net.run_for(5s);
  ASSERT_TRUE(net.node(0).id_conflict().has_value());
  EXPECT_EQ(net.node(0).id_conflict()->incarnation, 3u);
  EXPECT_TRUE(net.node(0).neighbours().empty());
}

}  // namespace
}  // namespace onemap::comms
