#include "comms/node.hpp"

#include <gtest/gtest.h>

#include <array>

#include "alone_node.hpp"
#include "comms/wire.hpp"
#include "sim_net.hpp"

namespace onemap::comms {
namespace {
using namespace std::chrono_literals;
using sim::SimNet;
using wire::DatagramType;

using sim::Alone;
using sim::datagram;
using sim::greeting;

TEST(Node, StrangersGetNoMoreThanTheySend) {
  Alone alone;
  ASSERT_TRUE(alone.node.append(alone.now, 1, 1, std::vector<std::uint8_t>(500)));
  alone.node.on_timer(alone.now);
  EXPECT_TRUE(alone.sent().empty());  // nobody is known
  std::size_t in = 0, out = 0;
  for (std::uint32_t k = 1; k <= 50; ++k) {
    const auto hello = greeting("friend", 5, 0, k);
    in += hello.size();
    alone.hear(hello);
    for (const auto& answer : alone.sent()) out += answer.size;
    alone.now += 10ms;
    alone.node.on_timer(alone.now);
    for (const auto& answer : alone.sent()) out += answer.size;
  }
  EXPECT_GT(out, 0u);
  EXPECT_LE(out, in);
  ASSERT_EQ(alone.node.neighbours().size(), 1u);
  EXPECT_FALSE(alone.node.neighbours()[0].alive);
}

TEST(Node, OnlyBeaconsOfStrangersAreRead) {
  Alone alone;
  alone.hear(datagram({DatagramType::unicast, 5, 77, 1}, [](wire::Encoder& out) { out.have_request(); }));
  EXPECT_EQ(alone.node.counters().of(Refusal::stranger), 1u);
  EXPECT_TRUE(alone.sent().empty());
  alone.befriend();
  EXPECT_TRUE(alone.node.neighbours()[0].alive);
  alone.hear(datagram({DatagramType::unicast, 5, 78, 2}, [](wire::Encoder& out) { out.ping(1); }));
  EXPECT_EQ(alone.node.counters().of(Refusal::wrong_receiver), 1u);
  alone.hear(datagram({DatagramType::unicast, 6, 77, 2}, [](wire::Encoder& out) { out.ping(1); }));
  EXPECT_EQ(alone.node.counters().of(Refusal::stranger), 2u);
  EXPECT_TRUE(alone.sent().empty());
  alone.hear(datagram({DatagramType::unicast, 5, 77, 2}, [](wire::Encoder& out) { out.ping(42); }));
  const auto answers = alone.sent();
  ASSERT_EQ(answers.size(), 1u);
  wire::Decoder decoder;
  ASSERT_EQ(decoder.decode(answers[0].bytes()), Refusal::count);
  EXPECT_EQ(std::get<wire::Pong>(decoder.frames()[0]).token, 42u);
  EXPECT_EQ(decoder.header().receiver, 5u);
}

TEST(Node, DuplicatesAndMalformedDatagramsChangeNothing) {
  Alone alone;
  alone.befriend();
  const LogId log{RobotId::from_name("friend"), 1, 5};
  const wire::HaveEntry entry{log, 3};
  auto have = datagram({DatagramType::unicast, 5, 77, 2}, [&](wire::Encoder& out) {
    out.have(entry_digest(log, 3), {&entry, 1});
    out.ping(1);
  });
  auto broken = have;
  broken.pop_back();  // the HAVE is whole, the PING is not: neither counts
  alone.hear(broken);
  EXPECT_EQ(alone.node.counters().of(Refusal::bad_frame), 1u);
  EXPECT_EQ(alone.node.records_missing(), 0u);
  EXPECT_TRUE(alone.sent().empty());
  alone.hear(have);
  EXPECT_EQ(alone.node.records_missing(), 3u);
  EXPECT_EQ(alone.sent().size(), 1u);  // PONG and WANT
  alone.hear(have);
  EXPECT_EQ(alone.node.counters().of(Refusal::duplicate), 1u);
  EXPECT_TRUE(alone.sent().empty());
}

TEST(Node, FarTooLateIsRefused) {
  Alone alone;
  alone.befriend();
  const auto ping = [](std::uint32_t counter) {
    return datagram({DatagramType::unicast, 5, 77, counter}, [](wire::Encoder& out) { out.ping(1); });
  };
  alone.hear(ping(9'999));  // so far ahead that another one has to confirm it
  EXPECT_EQ(alone.node.counters().of(Refusal::counter_jump), 1u);
  alone.hear(ping(10'000));
  alone.hear(ping(10'000 - 2047));
  EXPECT_EQ(alone.node.counters().of(Refusal::too_old), 0u);
  alone.hear(ping(10'000 - 2048));
  EXPECT_EQ(alone.node.counters().of(Refusal::too_old), 1u);
}

TEST(Node, OneIdTwoRobots) {
  Alone alone;
  alone.hear(greeting("self", 77, 0, 1));  // multicast loops back
  EXPECT_EQ(alone.node.counters().of(Refusal::own_echo), 1u);
  alone.hear(greeting("self", 78, 0, 1));  // somebody else with our name
  EXPECT_EQ(alone.node.counters().of(Refusal::id_conflict), 1u);
  EXPECT_TRUE(alone.sent().empty());
  // Two neighbours with one name: the first stays until it has been silent for long.
  alone.befriend("friend", 5, Endpoint::ipv4(127, 0, 0, 1, 8001));
  alone.hear(greeting("friend", 6, 77, 1), Endpoint::ipv4(127, 0, 0, 1, 8002));
  EXPECT_EQ(alone.node.counters().of(Refusal::id_conflict), 2u);
  alone.hear(greeting("friend", 5, 77, 1), Endpoint::ipv4(127, 0, 0, 1, 8003));
  EXPECT_EQ(alone.node.counters().of(Refusal::second_path), 1u);
  EXPECT_EQ(alone.node.neighbours().size(), 1u);
  alone.now += 11s;
  alone.hear(greeting("friend", 6, 77, 2), Endpoint::ipv4(127, 0, 0, 1, 8002));
  EXPECT_EQ(alone.node.neighbours().size(), 2u);
}

TEST(Node, NeighboursAreBounded) {
  NodeConfig config;
  config.max_neighbours = 4;
  Alone alone(config);
  for (std::uint16_t k = 0; k < 10; ++k)
    alone.hear(greeting(sim::numbered("friend", k).name(), 5, 77, 1),
               Endpoint::ipv4(127, 0, 0, static_cast<std::uint8_t>(k), 8000));
  EXPECT_EQ(alone.node.neighbours().size(), 4u);
  EXPECT_EQ(alone.node.counters().of(Refusal::neighbours_full), 6u);
}

TEST(Node, LiesAreCounted) {
  Alone alone;
  alone.befriend();
  const LogId own{RobotId::from_name("self"), 1, 77}, theirs{RobotId::from_name("friend"), 2, 5};
  const wire::HaveEntry ahead{own, 5}, real{theirs, 1};
  alone.hear(datagram({DatagramType::unicast, 5, 77, 2}, [&](wire::Encoder& out) { out.have(1, {&ahead, 1}); }));
  EXPECT_EQ(alone.node.counters().of(Refusal::own_log_ahead), 1u);
  const wire::WantEntry want{{theirs, 9}, 0, 1};
  alone.hear(datagram({DatagramType::unicast, 5, 77, 3}, [&](wire::Encoder& out) { out.want(10'000, {&want, 1}); }));
  EXPECT_EQ(alone.node.counters().of(Refusal::want_unknown), 1u);
  const Record record = sim::SignedLogs().next(theirs, 0, {1, 2, 3});
  alone.hear_record(5, 4, record);
  EXPECT_EQ(alone.node.counters().of(Refusal::data_unasked), 1u);
  alone.hear(datagram({DatagramType::unicast, 5, 77, 5}, [&](wire::Encoder& out) {
    out.have(entry_digest(theirs, 1), {&real, 1});
  }));
  EXPECT_EQ(alone.sent().size(), 1u);
  alone.hear_record(5, 6, record, sim::kStranger, 1);
  EXPECT_EQ(alone.node.counters().of(Refusal::data_bad_hash), 1u);
  EXPECT_TRUE(alone.node.frontier().empty());
  EXPECT_EQ(alone.sent().size(), 1u);  // asked for again
  alone.hear_record(5, 7, record);
  EXPECT_EQ(alone.node.frontier(), (VersionVector{{theirs, 1}}));
  EXPECT_EQ(alone.node.frontier_digest(), entry_digest(theirs, 1));
}

TEST(Node, CreditBoundsWhatWaitsAtTheServer) {
  Alone alone;
  alone.befriend();
  const auto id = alone.node.append(alone.now, 3, 1, std::vector<std::uint8_t>(200'000)).value();
  alone.sent();
  const wire::WantEntry all{id, 0, 65535};
  alone.hear(datagram({DatagramType::unicast, 5, 77, 2}, [&](wire::Encoder& out) { out.want(100'000, {&all, 1}); }));
  EXPECT_EQ(alone.node.counters().of(Refusal::want_over_credit), 1u);
  const wire::WantEntry some{id, 10, 20};
  alone.hear(datagram({DatagramType::unicast, 5, 77, 3}, [&](wire::Encoder& out) { out.want(100'000, {&some, 1}); }));
  alone.hear(datagram({DatagramType::unicast, 5, 77, 4}, [&](wire::Encoder& out) {
    out.want(100'000, {&some, 1});
  }));  // impatient
  for (int k = 0; k < 100; ++k) {
    alone.now += 10ms;
    alone.node.on_timer(alone.now);
    alone.sent();
  }
  EXPECT_EQ(alone.node.counters().sent(FrameType::data), 20u);
}

TEST(Node, RestoredStoreIsGivenOutFirstAndContinued) {
  MemoryStore store(1u << 20);
  NodeConfig config;
  config.self = RobotId::from_name("a");
  config.incarnation = 3;
  config.identity = sim::identity_of(config.self);
  sim::SignedLogs logs;
  for (std::uint8_t k = 0; k < 3; ++k) ASSERT_TRUE(store.append(logs.next({config.self, 1, 3}, 2, {k})));
  Node node(config, store);
  EXPECT_EQ(node.append(Instant{}, 1, 2, {9})->seq, 3u);
  std::shared_ptr<const Record> record;
  for (std::uint32_t k = 0; k < 4; ++k) {
    ASSERT_TRUE(node.next_applied(record));
    EXPECT_EQ(record->id.seq, k);
  }
  EXPECT_FALSE(node.next_applied(record));
  EXPECT_EQ(node.frontier_digest(), digest(store.frontier()));
}

TEST(Team, StatusTravelsAlongALine) {
  for (const double loss : {0.0, 0.3}) {
    SimNet net(21, {.loss = loss, .delay = 5ms});
    net.add_team(5, sim::line(5));
    for (std::size_t i = 0; i < 5; ++i) net.append(i, 1, 100);
    const auto all = [&](std::uint8_t flags) {
      for (std::size_t i = 0; i < 5; ++i)
        if (!sim::agrees(net.node(i), 5, flags)) return false;
      return true;
    };
    ASSERT_TRUE(net.run_until([&] { return all(0); }, 20s));
    EXPECT_FALSE(sim::agrees(net.node(0), 6, 0));
    for (std::size_t i = 0; i < 4; ++i) net.node(i).set_local_status(net.now(), 0xABCD, kStatusFinished);
    net.run_for(5s);
    EXPECT_FALSE(sim::agrees(net.node(0), 5, 0));  // robot 4 has another map
    const RobotStatus& last = net.node(4).team().at(RobotId::from_name("robot0"));
    EXPECT_EQ(last.map_digest, 0xABCDu);
    EXPECT_EQ(last.flags, kStatusFinished);
    EXPECT_EQ(last.frontier_digest, net.node(0).frontier_digest());
    net.node(4).set_local_status(net.now(), 0xABCD, kStatusFinished);
    const Instant start = net.now();
    ASSERT_TRUE(net.run_until([&] { return all(kStatusFinished); }, 20s));
    EXPECT_LT(net.now() - start, loss == 0.0 ? 500ms : 5s);
    net.append(2, 1, 100);
    net.run_for(20ms);
    EXPECT_FALSE(sim::agrees(net.node(2), 5, kStatusFinished));
    ASSERT_TRUE(net.run_until([&] { return all(kStatusFinished); }, 20s));
  }
}

TEST(Team, ManyRobotsShareOneTableOverSeveralFrames) {
  SimNet net(22, {.delay = 2ms});
  net.add_team(40, sim::line(40));
  for (std::size_t i = 0; i < 40; ++i) net.append(i, 0, 10);  // who never writes counts for its neighbours only
  ASSERT_TRUE(net.run_until(
      [&] {
        for (std::size_t i = 0; i < 40; ++i)
          if (!sim::agrees(net.node(i), 40, 0)) return false;
        return true;
      },
      120s));
}

TEST(Team, RestartWritesNewLogsAndGetsTheOldOnesBack) {
  SimNet net(23, {.loss = 0.1});
  net.add_team(3, sim::line(3));
  net.append(2, 1, 100);
  net.append(2, 1, 200);
  ASSERT_TRUE(net.run_until([&] { return net.equal(); }, 10s));
  NodeConfig again;
  again.incarnation = 2;
  again.peers = {SimNet::address(1)};
  net.restart(2, again);
  const RecordId fresh = net.append(2, 1, 300);
  EXPECT_EQ(fresh.seq, 0u);
  EXPECT_EQ(fresh.log.incarnation, 2u);
  ASSERT_TRUE(net.run_until([&] { return net.equal() && net.node(0).hops(fresh); }, 10s));
  EXPECT_EQ(net.node(2).frontier().at({RobotId::from_name("robot2"), 1, 1}), 2u);
  ASSERT_TRUE(net.run_until([&] { return sim::agrees(net.node(0), 3, 0); }, 10s));
  EXPECT_EQ(net.node(0).team().at(RobotId::from_name("robot2")).incarnation, 2u);
}

TEST(Team, NeighbourStatusTellsLossAndRoundTrip) {
  SimNet net(24, {.loss = 0.2, .delay = 10ms});
  net.add_team(2, sim::line(2));
  net.append(0, 3, 1'000'000);
  ASSERT_TRUE(net.run_until([&] { return net.equal(); }, 20s));
  net.run_for(1s);
  const auto status = net.node(1).neighbours();
  ASSERT_EQ(status.size(), 1u);
  EXPECT_EQ(status[0].robot.name(), "robot0");
  EXPECT_TRUE(status[0].alive);
  EXPECT_NEAR(status[0].loss, 0.2, 0.1);
  EXPECT_NEAR(to_seconds(status[0].round_trip), 0.020, 0.003);
  EXPECT_GT(status[0].bytes_in, 1'000'000u);
  EXPECT_EQ(status[0].frontier_digest, net.node(0).frontier_digest());
}

}  // namespace
}  // namespace onemap::comms
