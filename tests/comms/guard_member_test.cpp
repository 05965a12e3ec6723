// What broken or lying members of the team do to a Guard (comms/PROTOCOL.md, Sessions).
#include <gtest/gtest.h>

#include <set>

#include "support/guarded.hpp"

namespace onemap::comms::sim {
namespace {

using namespace std::chrono_literals;

TEST(GuardMember, EveryFlippedBitOfASealedDatagramIsSeen) {
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

TEST(GuardMember, ADatagramIsTakenOnce) {
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

TEST(GuardMember, AWordIsTakenOnce) {
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
TEST(GuardMember, NoNumberIsUsedTwice) {
  Guarded robot;
  OtherSide other(kTeam);
  ASSERT_TRUE(robot.meet(other, at(100)));
  std::set<std::uint64_t> used;
  for (const std::uint32_t counter : {5u, 6u, 6u, 3u, 7u, 0xFFFFFFFFu, 1u, 2u, 2u, 0x7FFFFFFFu, 0xFFFFFFFFu, 4u})
    EXPECT_TRUE(used.insert(sealed::counter_of(other.sealed(beacon_of(other.robot()), counter))).second) << counter;
}

TEST(GuardMember, WhoGreetsInAnothersNameIsRefused) {
  Guarded robot;
  OtherSide other(kTeam);
  ASSERT_TRUE(robot.meet(other, at(100)));
  robot.hear(at(100), other.sealed(beacon_of(RobotId::from_name("victim")), 1));
  EXPECT_EQ(robot.refused(Refusal::wrong_name), 1u);
  EXPECT_FALSE(robot.node.team().contains(RobotId::from_name("victim")));
}

TEST(GuardMember, AGreetingThatItsKeyDidNotSignIsRefused) {
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

TEST(GuardMember, WhoSpeaksNonsenseIsShutOutForLongerAndLonger) {
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

TEST(GuardMember, SevenMistakesAMinuteAreForgiven) {
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
TEST(GuardMember, ASessionMovesOnlyWhenTheNewAddressAnswers) {
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

TEST(GuardMember, AFullTableTakesNobodyInAndLosesNobody) {
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
}  // namespace onemap::comms::sim
