// Robots that never finish: they hold one map all the time, lose one of them, and get it back.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>

#include "support/running.hpp"

namespace onemap {
namespace {

using namespace std::chrono_literals;
using test::Robot;
using testing::HasSubstr;

std::string at(std::uint16_t port) { return fmt::format("127.0.0.1:{}", port); }

// Three robots in one room, in a line: a - b - c. Slow enough for three on a small machine.
struct Living : testing::Test {
  const test::TempFolder folder;
  const std::vector<std::uint16_t> ports{test::free_port(), test::free_port(), test::free_port()};
  std::deque<Robot> robots;

  void SetUp() override {
    folder.write("team.toml",
                 "[run]\nlost_after_s = 10\nlinger_s = 0\nmerge_while_mapping_s = 2\nmap_interval_s = 0.5\n");
    for (int i = 0; i < 3; ++i) start(i);
  }
  void start(int i) {
    std::vector<std::string> arguments{"--speed", "0.3", "--listen", at(ports[i]), "--config", folder / "team.toml"};
    for (const int other : {i - 1, i + 1})
      if (other >= 0 && other < 3) arguments.insert(arguments.end(), {"--peer", at(ports[other])});
    robots.emplace_back(folder, name(i),
                        fmt::format("simulated:living-room?robot={}&robots=3&frames=100000&seed=3", i + 1), arguments);
  }
  static std::string name(int i) { return std::string(1, static_cast<char>('a' + i)); }
  static bool all_agree(const std::vector<Robot*>& team, int in_map) {
    return std::ranges::all_of(team, [&](Robot* robot) {
      return robot->status("map_agreed", false) && robot->status("robots_in_map", 0) == in_map;
    });
  }
  bool agree(const std::vector<Robot*>& team, int in_map) {
    return test::wait_until([&] { return all_agree(team, in_map); }, 60s);
  }
  std::string logs() {
    std::string out;
    for (Robot& robot : robots) out += robot.log() + "\n";
    return out;
  }
};

TEST_F(Living, OneMapThroughDeathAndReturn) {
  Robot &a = robots[0], &b = robots[1], &c = robots[2];
  ASSERT_TRUE(agree({&a, &b, &c}, 3)) << logs();
  for (Robot* robot : {&a, &b, &c}) {
    EXPECT_EQ(robot->status("robots_finished", 9), 0);
    EXPECT_FALSE(robot->status("agreed", true)) << "that is for recordings";
    const auto pose = robot->status().at("pose");
    EXPECT_TRUE(pose.at("tracking").get<bool>());
    EXPECT_EQ(pose.at("T_odom_camera").size(), 7u);
    EXPECT_EQ(pose.at("T_map_odom").size(), 7u);
  }
  // The map grows with them, and stays one.
  const auto before = a.status("map_digest", std::string());
  const auto keyframes = a.status("keyframes", 0);
  ASSERT_TRUE(test::wait_until([&] { return a.status("keyframes", 0) > keyframes + 2; }, 60s));
  ASSERT_TRUE(test::wait_until([&] { return a.status("map_digest", before) != before; }, 20s));
  ASSERT_TRUE(agree({&a, &b, &c}, 3));

  kill(b.process().pid(), SIGKILL);
  ASSERT_TRUE(b.process().wait(10s));
  ASSERT_TRUE(a.says("robot b is not waited for any more", 40s)) << logs();
  start(1);
  Robot& again = robots[3];
  ASSERT_TRUE(again.says("link b's earlier life - b accepted", 90s)) << logs();
  const auto finds_itself = [&] {
    const auto status = again.status();
    return status.is_object() && !status.at("pose").at("T_map_odom").is_null();
  };
  ASSERT_TRUE(test::wait_until(finds_itself, 60s)) << logs();
  ASSERT_TRUE(agree({&a, &again, &c}, 3)) << logs();

  // Nobody finishes; each writes what it has.
  for (Robot* robot : {&a, &again, &c}) EXPECT_EQ(robot->stop(), 0) << robot->log();
  std::size_t lives_of_b = 0;
  for (const auto& file : std::filesystem::directory_iterator(a.out() / "global"))
    lives_of_b += file.path().filename().string().starts_with("b.") ? 1 : 0;
  EXPECT_EQ(lives_of_b, 2u) << "b.txt, and b.LIFE.txt";
}

}  // namespace
}  // namespace onemap
