// What strangers and broken or lying members do to a Guard (comms/PROTOCOL.md, Sessions).
#include <gtest/gtest.h>

#include <set>

#include "comms/guard.hpp"
#include "comms/memory_store.hpp"
#include "comms/wire.hpp"
#include "session/sealed_wire.hpp"
#include "support/other_side.hpp"
#include "support/sim_net.hpp"

namespace onemap::comms {
namespace {

using namespace std::chrono_literals;
using sim::Datagram;
using sim::OtherSide;
using sim::SimNet;

const TeamKey kTeam{{1, 2, 3}};

// One honest robot with a key, whom anybody can say anything, and what it answers.
struct Guarded {
  Guarded() : node(node_config(), store), guard(guard_config(), node, pins) { guard.on_timer(now); }
  static NodeConfig node_config() {
    NodeConfig config;
    config.self = RobotId::from_name("honest");
    config.sealed = true;
    return config;
  }
  static GuardConfig guard_config() {
    const NodeConfig node = node_config();
    GuardConfig config{node.self, node.incarnation, {}, kTeam, Identity(SecretSeed{1}), {}, {}, 64};
    config.random = [random = test::Random(5)](std::span<std::uint8_t> bytes) mutable {
      for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.next() >> 56);
    };
    return config;
  }
  std::vector<Datagram> hear(const Endpoint& from, const Datagram& bytes) {
    guard.on_datagram(now, from, bytes);
    return answers();
  }
  std::vector<Datagram> answers() {
    std::vector<Datagram> all;
    OutgoingDatagram out;
    while (guard.next_outgoing(out)) {
      all.emplace_back(out.bytes().begin(), out.bytes().end());
      sent_bytes += out.size;
    }
    return all;
  }
  void pass(Duration time) {
    now += time;
    guard.on_timer(now);
    answers();
  }
  // The other side becomes a neighbour; false: it does not.
  bool meet(OtherSide& other, const Endpoint& from) {
    const auto answer = hear(from, other.hello(now));
    if (answer.size() != 1 || answer[0].size() != sealed::kAnswerBytes) return false;
    const Datagram proof = other.proof(now, answer[0]);
    if (proof.empty()) return false;
    hear(from, proof);
    return guard.sessions() > 0;
  }
  std::uint64_t refused(Refusal reason) const { return guard.counters().of(reason); }

  Instant now{1s};
  MemoryStore store{1u << 20};
  Pins pins;
  Node node;
  Guard guard;
  std::size_t sent_bytes = 0;
};

Endpoint at(std::uint16_t port) { return Endpoint::ipv4(192, 168, 7, static_cast<std::uint8_t>(port / 100), port); }

Datagram beacon_of(const RobotId& robot) {
  std::array<std::uint8_t, kMaxDatagramBytes> buffer;
  wire::Encoder out(buffer, {});
  out.beacon({robot, 0, 0, 1, 0});
  return {buffer.begin() + wire::kHeaderBytes, buffer.begin() + static_cast<std::ptrdiff_t>(out.size())};
}

TEST(GuardHostile, GarbageOfEveryShapeGetsSilence) {
  Guarded robot;
  test::Random random(3);
  for (int i = 0; i < 20'000; ++i) {
    Datagram bytes(static_cast<std::size_t>(random.integer(0, 1200)));
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.next());
    if (bytes.size() >= 4 && i % 4 != 0) {  // what looks like ours
      bytes[0] = sealed::kMagicAndVersion;
      bytes[1] = static_cast<std::uint8_t>(random.integer(0, 10));
      bytes[2] = bytes[3] = 0;
    }
    if (i % 8 == 1) {
      bytes.resize(sealed::kHelloBytes);
      bytes[0] = sealed::kMagicAndVersion;
      bytes[1] = static_cast<std::uint8_t>(sealed::Type::hello);
      bytes[2] = bytes[3] = 0;
    }
    ASSERT_TRUE(robot.hear(at(100), bytes).empty()) << i;
  }
  EXPECT_EQ(robot.sent_bytes, 0u);
  EXPECT_GE(robot.refused(Refusal::bad_mac), 2500u);
  EXPECT_EQ(robot.guard.counters().datagrams_received, 20'000u);
}

TEST(GuardHostile, AnotherTeamsHelloGetsSilence) {
  Guarded robot;
  OtherSide other(TeamKey{{9}});
  EXPECT_TRUE(robot.hear(at(100), other.hello(robot.now)).empty());
  EXPECT_EQ(robot.refused(Refusal::bad_mac), 1u);
}

TEST(GuardHostile, EveryFlippedBitOfAHandshakeIsSeen) {
  for (std::size_t bit = 0; bit < 8 * sealed::kHelloMac2At; bit += 3) {
    Guarded robot;
    OtherSide other(kTeam);
    Datagram hello = other.hello(robot.now);
    hello[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
    ASSERT_TRUE(robot.hear(at(100), hello).empty()) << bit;
  }
  for (std::size_t bit = 0; bit < 8 * sealed::kProofBytes; bit += 7) {
    Guarded robot;
    OtherSide other(kTeam);
    const auto answer = robot.hear(at(100), other.hello(robot.now));
    Datagram proof = other.proof(robot.now, answer.at(0));
    proof[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
    robot.hear(at(100), proof);
    ASSERT_EQ(robot.guard.sessions(), 0u) << bit;
    proof[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
    robot.hear(at(100), proof);
    ASSERT_EQ(robot.guard.sessions(), 1u) << "a forged proof ended the handshake of the true one " << bit;
  }
}

TEST(GuardHostile, EveryPrefixOfEveryDatagramIsRefused) {
  Guarded robot;
  OtherSide other(kTeam);
  const Datagram hello = other.hello(robot.now);
  for (std::size_t size = 0; size < hello.size(); ++size)
    ASSERT_TRUE(
        robot.hear(at(100), Datagram(hello.begin(), hello.begin() + static_cast<std::ptrdiff_t>(size))).empty());
  ASSERT_TRUE(robot.meet(other, at(100)));
  const Datagram good = other.sealed(beacon_of(other.robot()), 1);
  for (std::size_t size = 0; size < good.size(); ++size) {
    robot.hear(at(100), Datagram(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)));
    ASSERT_EQ(robot.guard.counters().received(FrameType::beacon), 0u) << size;
  }
  robot.hear(at(100), good);
  EXPECT_EQ(robot.guard.counters().received(FrameType::beacon), 1u);
}

TEST(GuardHostile, EveryFlippedBitOfASealedDatagramIsSeen) {
  Guarded robot;
  OtherSide other(kTeam);
  ASSERT_TRUE(robot.meet(other, at(100)));
  const Datagram good = other.sealed(beacon_of(other.robot()), 1);
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    Datagram bad = good;
    bad[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
    robot.hear(at(100), bad);
    ASSERT_EQ(robot.guard.counters().received(FrameType::beacon), 0u) << bit;
  }
  EXPECT_GT(robot.refused(Refusal::bad_seal), 100u);
}

TEST(GuardHostile, ADatagramIsTakenOnce) {
  Guarded robot;
  OtherSide other(kTeam);
  ASSERT_TRUE(robot.meet(other, at(100)));
  const Datagram once = other.sealed(beacon_of(other.robot()), 1);
  for (int i = 0; i < 5; ++i) robot.hear(at(100), once);
  EXPECT_EQ(robot.guard.counters().received(FrameType::beacon), 1u);
  EXPECT_EQ(robot.refused(Refusal::duplicate), 4u);
  robot.hear(at(100), other.sealed(beacon_of(other.robot()), 20'000));
  const Datagram late = other.sealed(beacon_of(other.robot()), 30'000);
  robot.hear(at(100), late);
  robot.hear(at(100), once);
  EXPECT_EQ(robot.refused(Refusal::too_old), 1u);
}

TEST(GuardHostile, AWordIsTakenOnce) {
  Guarded robot;
  OtherSide other(kTeam);
  ASSERT_TRUE(robot.meet(other, at(100)));
  Datagram probe(sealed::kOwnBytes);
  other.session().say(probe, sealed::Word::probe, 1);
  EXPECT_EQ(robot.hear(at(100), probe).size(), 1u);
  EXPECT_TRUE(robot.hear(at(100), probe).empty());
  EXPECT_EQ(robot.refused(Refusal::duplicate), 1u);
}

// Whatever the writer counts: two datagrams under one key and number would give both away.
TEST(GuardHostile, NoNumberIsUsedTwice) {
  Guarded robot;
  OtherSide other(kTeam);
  ASSERT_TRUE(robot.meet(other, at(100)));
  std::set<std::uint64_t> used;
  for (const std::uint32_t counter : {5u, 6u, 6u, 3u, 7u, 0xFFFFFFFFu, 1u, 2u, 2u, 0x7FFFFFFFu, 0xFFFFFFFFu, 4u})
    EXPECT_TRUE(used.insert(sealed::counter_of(other.sealed(beacon_of(other.robot()), counter))).second) << counter;
}

TEST(GuardHostile, AWholeRecordedHandshakePlayedAgainMakesNoSession) {
  Guarded robot;
  OtherSide other(kTeam);
  const Datagram hello = other.hello(robot.now);
  const auto answer = robot.hear(at(100), hello);
  const Datagram proof = other.proof(robot.now, answer.at(0));
  robot.pass(7s);
  EXPECT_EQ(robot.hear(at(200), hello).size(), 1u) << "an answer, not larger than what came";
  EXPECT_TRUE(robot.hear(at(200), proof).empty());
  EXPECT_EQ(robot.guard.sessions(), 0u);
  EXPECT_TRUE(robot.node.neighbours().empty());
}

TEST(GuardHostile, NoAnswerIsLargerThanWhatCame) {
  Guarded robot;
  std::size_t came = 0;
  for (std::uint16_t i = 0; i < 200; ++i) {
    OtherSide other(kTeam, i + 1u);
    const Datagram hello = other.hello(robot.now);
    came += hello.size();
    robot.hear(at(static_cast<std::uint16_t>(1000 + i)), hello);
    ASSERT_LE(robot.sent_bytes, came);
  }
  for (int i = 0; i < 20; ++i) robot.pass(1s);
  EXPECT_LE(robot.sent_bytes, came);
}

// Half-open handshakes are few, and an address that shows that it receives there gets through a flood of them.
TEST(GuardHostile, UnderAFloodOfHellosAnHonestRobotGetsInByItsCookie) {
  Guarded robot;
  OtherSide insider(kTeam, 50);
  std::size_t cookies = 0;
  for (int i = 0; i < 5000; ++i) {
    robot.now += 1ms;
    for (const Datagram& answer : robot.hear(at(static_cast<std::uint16_t>(2000 + i)), insider.hello(robot.now)))
      cookies += answer.size() == sealed::kCookieBytes ? 1 : 0;
  }
  EXPECT_GT(cookies, 4800u) << "almost nothing was computed for them";
  EXPECT_GT(robot.refused(Refusal::under_load), 4800u);
  OtherSide honest(kTeam, 51, "late");
  auto answer = robot.hear(at(100), honest.hello(robot.now));
  ASSERT_EQ(answer.at(0).size(), sealed::kCookieBytes);
  const auto cookie = honest.cookie_in(answer[0]);
  ASSERT_TRUE(cookie.has_value());
  EXPECT_EQ(robot.hear(at(300), honest.hello_again(robot.now, cookie)).at(0).size(), sealed::kCookieBytes)
      << "a cookie is worth nothing at another address";
  answer = robot.hear(at(100), honest.hello_again(robot.now, cookie));
  ASSERT_EQ(answer.at(0).size(), sealed::kAnswerBytes);
  robot.hear(at(100), honest.proof(robot.now, answer[0]));
  EXPECT_EQ(robot.guard.sessions(), 1u);
}

TEST(GuardHostile, ACookieThatNobodyAskedForIsRefused) {
  Guarded robot;
  OtherSide other(kTeam);
  const Datagram hello = other.hello(robot.now);
  CookieJar jar;
  const auto cookie = jar.reply(robot.now, at(100), hello, other.team().cookie, other.random());
  EXPECT_TRUE(robot.hear(at(100), Datagram(cookie.begin(), cookie.end())).empty());
  EXPECT_EQ(robot.refused(Refusal::bad_cookie), 1u);
}

TEST(GuardHostile, WhoGreetsInAnothersNameIsRefused) {
  Guarded robot;
  OtherSide other(kTeam);
  ASSERT_TRUE(robot.meet(other, at(100)));
  robot.hear(at(100), other.sealed(beacon_of(RobotId::from_name("victim")), 1));
  EXPECT_EQ(robot.refused(Refusal::wrong_name), 1u);
  EXPECT_FALSE(robot.node.team().contains(RobotId::from_name("victim")));
}

TEST(GuardHostile, AGreetingThatItsKeyDidNotSignIsRefused) {
  Guarded robot;
  OtherSide other(kTeam);
  for (std::size_t byte = 0; byte < sealed::kGreetingBytes; byte += 5) {
    OtherSide liar(kTeam);
    liar.own().greeting[byte] ^= 1;
    EXPECT_FALSE(robot.meet(liar, at(100))) << byte;
  }
  OtherSide thief(kTeam, 60);
  thief.own().greeting = other.own().greeting;  // a true one, of another's static key
  EXPECT_FALSE(robot.meet(thief, at(100)));
  EXPECT_GT(robot.refused(Refusal::bad_identity), 20u);
  EXPECT_TRUE(robot.pins.all().empty());
}

TEST(GuardHostile, WhoSpeaksNonsenseIsShutOutForLongerAndLonger) {
  Guarded robot;
  OtherSide other(kTeam);
  const Datagram nonsense{0x07, 0xFF, 0xFF};
  for (const auto penalty : {60s, 120s, 240s}) {
    ASSERT_TRUE(robot.meet(other, at(100))) << penalty.count();
    for (std::uint32_t i = 1; i <= 8; ++i) robot.hear(at(100), other.sealed(nonsense, i));
    EXPECT_EQ(robot.guard.sessions(), 0u);
    GuardEvent event;
    ASSERT_TRUE(robot.guard.next_event(event));
    EXPECT_EQ(event.what, GuardEvent::What::shut_out);
    EXPECT_EQ(event.robot, other.robot());
    EXPECT_EQ(event.penalty, penalty);
    robot.pass(penalty - 1s);
    EXPECT_FALSE(robot.meet(other, at(100)));
    robot.pass(10s);
  }
  EXPECT_GE(robot.refused(Refusal::shut_out), 3u);
}

TEST(GuardHostile, SevenMistakesAMinuteAreForgiven) {
  Guarded robot;
  OtherSide other(kTeam);
  ASSERT_TRUE(robot.meet(other, at(100)));
  const Datagram nonsense{0x07, 0xFF, 0xFF};
  std::uint32_t counter = 0;
  for (int minute = 0; minute < 2; ++minute) {
    for (int i = 0; i < 7; ++i) robot.hear(at(100), other.sealed(nonsense, ++counter));
    EXPECT_EQ(robot.guard.sessions(), 1u);
    robot.pass(61s);
  }
}

// Somebody on the way sends on what he caught, from an address where he would like our traffic to go.
TEST(GuardHostile, ASessionMovesOnlyWhenTheNewAddressAnswers) {
  Guarded robot;
  OtherSide other(kTeam);
  ASSERT_TRUE(robot.meet(other, at(100)));
  const auto probes = robot.hear(at(300), other.sealed(beacon_of(other.robot()), 1));
  ASSERT_FALSE(probes.empty());
  EXPECT_EQ(robot.node.neighbours().at(0).endpoint, at(100));
  Transport::Said said{};
  for (const Datagram& datagram : probes)
    if (datagram.size() == sealed::kOwnBytes) {
      ASSERT_EQ(other.session().hear(datagram, said), Refusal::count);
    }
  ASSERT_EQ(said.word, sealed::Word::probe);
  Datagram answer(sealed::kOwnBytes);
  other.session().say(answer, sealed::Word::probe_answer, said.token ^ 1);
  robot.hear(at(300), answer);
  EXPECT_EQ(robot.node.neighbours().at(0).endpoint, at(100));
  other.session().say(answer, sealed::Word::probe_answer, said.token);
  robot.hear(at(400), answer);
  EXPECT_EQ(robot.node.neighbours().at(0).endpoint, at(100));
  other.session().say(answer, sealed::Word::probe_answer, said.token);
  robot.hear(at(300), answer);
  EXPECT_EQ(robot.node.neighbours().at(0).endpoint, at(300));
  EXPECT_TRUE(robot.node.neighbours().at(0).alive);
}

// 100,000 datagrams of garbage a second, for two seconds, of every kind that costs something: an honest pair's records
// take the same virtual time, and nobody answers.
TEST(GuardHostile, AFloodOfGarbageChangesNothingBetweenHonestRobots) {
  const auto transfer = [](bool flood) {
    SimNet net(21, {});
    NodeConfig config;
    config.sealed = true;
    net.add_team(2, sim::line(2), config);
    net.run_until([&] { return net[0].guard->sessions() == 1 && net[1].guard->sessions() == 1; }, 5s);
    for (int i = 0; i < 80; ++i) net.append(0, 3, 50'000);
    OtherSide stranger(TeamKey{{9}});
    std::vector<Datagram> garbage;
    garbage.push_back(stranger.hello(net.now()));
    Datagram sealed_of_nobody(1200, 0x55);
    sealed_of_nobody[0] = sealed::kMagicAndVersion;
    sealed_of_nobody[1] = static_cast<std::uint8_t>(sealed::Type::frames);
    sealed_of_nobody[2] = sealed_of_nobody[3] = 0;
    garbage.push_back(sealed_of_nobody);
    Datagram group = sealed_of_nobody;
    group[1] = static_cast<std::uint8_t>(sealed::Type::group);
    garbage.push_back(group);
    garbage.emplace_back(300, 0xB1);
    const Instant begun = net.now();
    while (!net.equal() && net.now() - begun < 10s) {
      if (flood)
        for (int i = 0; i < 1000; ++i)
          net.inject(1, at(static_cast<std::uint16_t>(100 + i)), garbage[static_cast<std::size_t>(i) % garbage.size()]);
      net.run_for(10ms);
    }
    return net.now() - begun;
  };
  const Duration calm = transfer(false), flooded = transfer(true);
  EXPECT_LT(calm, 10s);
  EXPECT_LE(flooded, calm + calm / 20);
}

TEST(GuardHostile, AFullTableTakesNobodyInAndLosesNobody) {
  Guarded robot;
  for (std::uint16_t i = 0; i < 100; ++i) {
    OtherSide other(kTeam, 200u + i, "m" + std::to_string(i));
    robot.now += 50ms;
    robot.meet(other, at(static_cast<std::uint16_t>(3000 + 100 * i)));
  }
  EXPECT_LE(robot.guard.sessions(), 64u);
  EXPECT_GE(robot.guard.sessions(), 60u);
  EXPECT_GT(robot.refused(Refusal::neighbours_full), 0u);
}

}  // namespace
}  // namespace onemap::comms
