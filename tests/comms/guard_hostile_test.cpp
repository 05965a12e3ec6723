// What strangers do to a Guard: whoever lacks the team's key, or repeats what he caught (comms/PROTOCOL.md, Sessions).
#include <gtest/gtest.h>

#include "support/guarded.hpp"
#include "support/sim_net.hpp"

namespace onemap::comms::sim {
namespace {

using namespace std::chrono_literals;

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

// Group datagrams can be caught and sent on under any address: who is in no group is not made to speak there by them.
TEST(GuardHostile, AGroupDatagramFromAnAddressThatNobodyGreetsIsNotAnswered) {
  Guarded robot;
  OtherSide other(kTeam);
  GroupSeal seal(other.team().group, 1);
  for (int i = 0; i < 5; ++i) {
    EXPECT_TRUE(robot.hear(at(100), sim::group_beacon(seal, other, other.robot())).empty());
    robot.pass(1s);
  }
  EXPECT_EQ(robot.sent_bytes, 0u);
  EXPECT_EQ(robot.refused(Refusal::stranger), 5u);
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

}  // namespace
}  // namespace onemap::comms::sim
