// Each row of PROTOCOL.md's table "What a bad datagram gets": what comes back, and which counter says it.
#include <gtest/gtest.h>

#include <algorithm>

#include "support/guarded.hpp"

namespace onemap::comms::sim {
namespace {

using namespace std::chrono_literals;

const Endpoint kHome = at(100), kElsewhere = at(300);
const Endpoint kGroup = Endpoint::ipv4(239, 1, 1, 1, 7000);

Datagram of_type(sealed::Type type, std::size_t size) {
  Datagram bytes(size, 0x55);
  bytes[0] = sealed::kMagicAndVersion;
  bytes[1] = static_cast<std::uint8_t>(type);
  bytes[2] = bytes[3] = 0;
  return bytes;
}

// It is counted once, as this, and nothing comes back.
void expect_silence(Guarded& robot, const Endpoint& from, const Datagram& bytes, Refusal counter) {
  const std::uint64_t before = robot.refused(counter);
  EXPECT_TRUE(robot.hear(from, bytes).empty()) << name(counter);
  EXPECT_EQ(robot.refused(counter), before + 1) << name(counter);
}

TEST(HostileTable, WhatIsNoDatagramOfOurs) {
  Guarded robot;
  Datagram bytes = of_type(sealed::Type::frames, 100);
  expect_silence(robot, kHome, Datagram(kMaxDatagramBytes + 1, 0xB2), Refusal::too_long);
  expect_silence(robot, kHome, {0xB2, 5, 0}, Refusal::too_short);
  expect_silence(robot, kHome, Datagram(200, 0xB1), Refusal::not_sealed);
  expect_silence(robot, kHome, of_type(static_cast<sealed::Type>(7), 100), Refusal::bad_type);
  bytes[0] = 0x42;
  expect_silence(robot, kHome, bytes, Refusal::bad_magic);
  bytes = of_type(sealed::Type::frames, 100);
  bytes[2] = 1;
  expect_silence(robot, kHome, bytes, Refusal::bad_reserved);
  for (const auto type : {sealed::Type::hello, sealed::Type::answer, sealed::Type::proof, sealed::Type::cookie})
    expect_silence(robot, kHome, of_type(type, 100), Refusal::bad_size);
}

TEST(HostileTable, HandshakesOfStrangers) {
  Guarded robot;
  expect_silence(robot, kHome, of_type(sealed::Type::hello, sealed::kHelloBytes), Refusal::bad_mac);
  expect_silence(robot, kHome, of_type(sealed::Type::answer, sealed::kAnswerBytes), Refusal::bad_mac);
  expect_silence(robot, kHome, of_type(sealed::Type::proof, sealed::kProofBytes), Refusal::bad_mac);
  expect_silence(robot, kHome, of_type(sealed::Type::cookie, sealed::kCookieBytes), Refusal::bad_cookie);
}

// The true owner of an address gets an ANSWER that it did not ask for, a fifth of what was spent on it, and no session
// comes of it: whoever forged the address does not see the answer that the proof needs.
TEST(HostileTable, AHandshakeUnderAForgedAddress) {
  Guarded robot;
  OtherSide other(kTeam);
  const Datagram hello = other.hello(robot.now);
  std::size_t came = 0;
  for (std::uint16_t k = 0; k < 20; ++k) {
    came += hello.size();
    EXPECT_EQ(robot.hear(at(static_cast<std::uint16_t>(1000 + 100 * k)), hello).size(), 1u);
    EXPECT_LE(5 * robot.sent_bytes, came + came / 5);
  }
  const Datagram answer = robot.hear(kHome, other.hello(robot.now)).at(0);
  expect_silence(robot, kElsewhere, other.proof(robot.now, answer), Refusal::bad_handshake);
  EXPECT_EQ(robot.guard.sessions(), 0u);
}

TEST(HostileTable, FramesOfASession) {
  Guarded robot;
  OtherSide other(kTeam);
  expect_silence(robot, kHome, of_type(sealed::Type::frames, 200), Refusal::unknown_session);
  ASSERT_TRUE(robot.meet(other, kHome));
  const Datagram good = other.sealed(beacon_of(other.robot()), 1);
  Datagram forged = good;
  forged.back() ^= 1;
  for (int k = 0; k < 100; ++k) expect_silence(robot, kHome, forged, Refusal::bad_seal);
  EXPECT_EQ(robot.guard.sessions(), 1u) << "nobody can end it so";
  robot.hear(kHome, good);
  expect_silence(robot, kHome, good, Refusal::duplicate);
  robot.hear(kHome, other.sealed(beacon_of(other.robot()), 10'000));
  expect_silence(robot, kHome, good, Refusal::too_old);
  const RobotId victim = RobotId::from_name("victim");
  expect_silence(robot, kHome, other.sealed(beacon_of(victim), 10'001), Refusal::wrong_name);
}

// A datagram of the session that somebody sends on under his own address: one probe, that is no larger, and all that is
// said goes on going where it went.
TEST(HostileTable, FramesUnderAForgedAddress) {
  Guarded robot;
  OtherSide other(kTeam);
  ASSERT_TRUE(robot.meet(other, kHome));
  const Datagram ping{static_cast<std::uint8_t>(FrameType::ping), 4, 0, 1, 2, 3, 4};
  const auto probes_in = [](const std::vector<Datagram>& answers) {
    return std::ranges::count_if(
        answers, [](const Datagram& one) { return one[1] == static_cast<std::uint8_t>(sealed::Type::own); });
  };
  EXPECT_EQ(probes_in(robot.hear(kElsewhere, other.sealed(ping, 1))), 0) << "39 bytes are not worth one of 41";
  const Datagram caught = other.sealed(beacon_of(other.robot()), 2);
  EXPECT_EQ(probes_in(robot.hear(kElsewhere, caught)), 1);
  EXPECT_LE(sealed::kOwnBytes, caught.size());
  EXPECT_EQ(robot.node.neighbours().at(0).endpoint, kHome);
}

TEST(HostileTable, GroupDatagrams) {
  Guarded robot(kGroup), alone;
  OtherSide other(kTeam);
  GroupSeal theirs(other.team().group, 1), ours(other.team().group, 1), another_life(other.team().group, 9);
  const RobotId self = RobotId::from_name("honest");
  EXPECT_FALSE(robot.answers().empty()) << "its own to the group";
  expect_silence(robot, kHome, of_type(sealed::Type::group, 120), Refusal::bad_seal);
  const Datagram once = group_beacon(theirs, other, other.robot());
  expect_silence(alone, kHome, once, Refusal::stranger);
  EXPECT_FALSE(robot.hear(kHome, once).empty()) << "it is greeted";
  expect_silence(robot, kElsewhere, once, Refusal::duplicate);
  expect_silence(robot, kElsewhere, group_beacon(ours, other, self), Refusal::own_echo);
  expect_silence(robot, kElsewhere, group_beacon(another_life, other, self), Refusal::id_conflict);
  ASSERT_TRUE(robot.node.id_conflict().has_value());
  EXPECT_EQ(robot.node.id_conflict()->where, kElsewhere);
}

}  // namespace
}  // namespace onemap::comms::sim
