// A network that is not there, comes, or changes, under real daemons in worlds of their own.
#include <gtest/gtest.h>

#include "support/team_key.hpp"
#include "support/walled.hpp"

namespace onemap {
namespace {

using namespace std::chrono_literals;
using test::TempFolder;
using test::Walled;

constexpr const char* kEndlessWalk = "simulated:living-room?seed=3&frames=100000&width=320&height=240";

TEST(Network, NoneAtAllIsWaitedForAndTheRobotMaps) {
  if (const auto missing = Walled::missing("-n"); !missing.empty()) GTEST_SKIP() << missing;
  const TempFolder folder;
  folder.write("robot.toml",
               "[network]\nlisten = \"0.0.0.0:4600\"\npeers = [\"10.7.0.2:4600\"]\n[team]\nkey_file = \"" +
                   test::team_key(folder) + "\"\n");
  Walled robot(folder, "-n", "", kEndlessWalk, "--config " + (folder / "robot.toml"));
  ASSERT_TRUE(test::wait_until([&] { return robot.frames() > 20; }, 60s)) << robot.log();
  EXPECT_TRUE(robot.says("nothing can be sent: is there a network")) << robot.log();
  EXPECT_EQ(robot.within("ip link set lo up && ip addr add 10.7.0.1/24 dev lo"), 0);
  EXPECT_TRUE(robot.says("the network takes datagrams again")) << robot.log();
  EXPECT_TRUE(robot.goes_on());
  EXPECT_EQ(robot.stop(), 0) << robot.log();
}

// A cable from one's world to the other's, with their addresses 10.7.0.1 and 10.7.0.2; what went wrong, else empty.
std::string plug(const Walled& a, const Walled& b) {
  const auto made = test::say(fmt::format(
      "sleep 1; ip link add {0}a type veth peer name {0}b && ip link set {0}a netns {1} name eth0 && ip link set {0}b "
      "netns {2} name eth0",
      fmt::format("om{}", getpid()), a.process().pid(), b.process().pid()));
  if (made.status != 0) return made.output;
  for (const auto& [robot, address] : {std::pair(&a, "10.7.0.1/24"), std::pair(&b, "10.7.0.2/24")})
    EXPECT_EQ(robot->within(fmt::format("ip link set lo up; ip link set eth0 up; ip addr add {} dev eth0", address)),
              0);
  return {};
}

// They start before there is a network, with the team's key and no word of each other.
TEST(Network, RobotsWithNothingButAKeyMeetWhenThereIsANetwork) {
  if (const auto missing = Walled::missing("-n"); !missing.empty()) GTEST_SKIP() << missing;
  const TempFolder folders[2];
  for (const TempFolder& folder : folders) {
    test::team_key(folder, "out/team.key");
  }
  Walled a(folders[0], "-n", "", kEndlessWalk, "--config /dev/null", "a");
  Walled b(folders[1], "-n", "", kEndlessWalk, "--config /dev/null", "b");
  for (Walled* robot : {&a, &b}) {
    ASSERT_TRUE(test::wait_until([&] { return robot->frames() > 5; }, 60s)) << robot->log();
    EXPECT_TRUE(robot->says("nothing can be sent: is there a network")) << robot->log();
  }
  if (const std::string why = plug(a, b); !why.empty()) GTEST_SKIP() << "no cables between namespaces here: " << why;
  for (Walled* robot : {&a, &b}) EXPECT_EQ(robot->within("ip route add 224.0.0.0/4 dev eth0"), 0);
  EXPECT_TRUE(b.says("neighbour a at 10.7.0.1:")) << b.log();
  EXPECT_TRUE(a.says("neighbour b at 10.7.0.2:")) << a.log();
  EXPECT_EQ(a.stop(), 0) << a.log();
  EXPECT_EQ(b.stop(), 0) << b.log();
}

// Two robots on one cable, in worlds of their own; one gets another address while they work.
TEST(Network, AnAddressThatChangesIsFollowed) {
  if (const auto missing = Walled::missing("-n"); !missing.empty()) GTEST_SKIP() << missing;
  const TempFolder a_folder, b_folder;
  const auto settings = [](const TempFolder& folder, const std::string& peer) {
    folder.write("robot.toml", "[network]\nlisten = \"0.0.0.0:4600\"\npeers = [\"" + peer +
                                   ":4600\"]\n[run]\nmerge_while_mapping_s = 1\n[team]\nkey_file = \"" +
                                   test::team_key(folder) + "\"\n");
    return "--config " + folder / "robot.toml";
  };
  const std::string wait = "until ip -4 -o addr show dev eth0 2>/dev/null | grep -q inet; do sleep 0.1; done";
  const std::string walk = "simulated:living-room?seed=3&robots=2&frames=100000&width=320&height=240&robot=";
  Walled a(a_folder, "-n", wait, walk + "1", settings(a_folder, "10.7.0.2"), "a");
  Walled b(b_folder, "-n", wait, walk + "2", settings(b_folder, "10.7.0.1"), "b");
  if (const std::string why = plug(a, b); !why.empty()) GTEST_SKIP() << "no cables between namespaces here: " << why;
  ASSERT_TRUE(b.says("neighbour a at 10.7.0.1:4600 is heard")) << b.log();
  ASSERT_EQ(a.within("ip addr add 10.7.0.3/24 dev eth0; ip addr del 10.7.0.1/24 dev eth0; "
                     "ip addr add 10.7.0.3/24 dev eth0; true"),
            0);
  const auto agree = [&] {
    const auto one = a.status(), other = b.status();
    return one.is_object() && other.is_object() && one.value("map_agreed", false) && other.value("map_agreed", false) &&
           one.value("robots_in_map", 0) == 2 && one.value("map_digest", "") == other.value("map_digest", "x");
  };
  EXPECT_TRUE(test::wait_until(agree, 180s)) << a.log() << b.log();
  const auto keyframes = b.status().value("keyframes", 0);
  EXPECT_TRUE(test::wait_until([&] { return b.status().value("keyframes", 0) > keyframes + 2; }, 60s));
  EXPECT_TRUE(test::wait_until(agree, 180s)) << "what is new comes, too" << a.log() << b.log();
  EXPECT_EQ(a.stop(), 0) << a.log();
  EXPECT_EQ(b.stop(), 0) << b.log();
}

}  // namespace
}  // namespace onemap
