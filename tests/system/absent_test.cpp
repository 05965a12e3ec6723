// Robots that are not there, not alone with their name, die, or cannot hold what there is: the others say so, and end.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "comms/udp/udp_port.hpp"
#include "support/running.hpp"

namespace onemap {
namespace {

using test::at;
using test::Robot;
using test::TempFolder;
using testing::HasSubstr;
using testing::Not;

std::string camera(int robot, int frames) {
  return fmt::format("simulated:living-room?robot={}&robots=3&frames={}&seed=3", robot, frames);
}

std::filesystem::path settings(const TempFolder& folder, const std::string& toml) {
  folder.write("team.toml", toml);
  return folder / "team.toml";
}

TEST(Absent, APeerThatWasNeverHeardIsNamedAndTheWorkIsUnfinished) {
  const TempFolder folder;
  const auto port = test::free_port();
  const auto config = settings(folder, "[run]\npeer_wait_s = 2\nlinger_s = 0\n");
  Robot robot(folder, "one", camera(1, 20),
              {"--once", "--speed", "max", "--listen", "127.0.0.1:0", "--peer", at(port), "--config", config});
  EXPECT_EQ(robot.ends(), 3) << robot.log();
  EXPECT_THAT(robot.log(), HasSubstr("peer " + at(port) + " was never heard"));
  EXPECT_TRUE(std::filesystem::exists(robot.out() / "report.json")) << "what there is is written";
}

TEST(Absent, TwoRobotsWithOneNameAreBothTold) {
  const TempFolder folder;
  const auto a = test::free_port(), b = test::free_port();
  const auto config = settings(folder, "[run]\npeer_wait_s = 3\nlinger_s = 0\n");
  const std::vector<std::string> common{"--once", "--speed", "max", "--config", config};
  const auto with = [&](std::uint16_t own, std::uint16_t other) {
    auto all = common;
    all.insert(all.end(), {"--listen", at(own), "--peer", at(other)});
    return all;
  };
  Robot first(folder, "first", camera(1, 20), with(a, b), "same"),
      second(folder, "second", camera(2, 20), with(b, a), "same");
  EXPECT_EQ(first.ends(), 3) << first.log();
  EXPECT_EQ(second.ends(), 3) << second.log();
  EXPECT_THAT(first.log(), HasSubstr("id same is also in use at " + at(b)));
  EXPECT_THAT(second.log(), HasSubstr("id same is also in use at " + at(a)));
}

TEST(Absent, WhenARobotDiesTheOthersSayWhomTheyWaitForAndThenAgreeWithoutIt) {
  const TempFolder folder;
  const auto a = test::free_port(), b = test::free_port(), c = test::free_port();
  const auto config = settings(folder, "[run]\nlost_after_s = 14\nlinger_s = 1\nmerge_while_mapping_s = 0\n");
  const auto with = [&](std::uint16_t own, const std::vector<std::uint16_t>& others, const std::string& speed) {
    std::vector<std::string> all{"--once", "--speed", speed, "--listen", at(own), "--config", config};
    for (const auto other : others) all.insert(all.end(), {"--peer", at(other)});
    return all;
  };
  // The one that dies has the lowest name: it would verify all pairs and decide for the team.
  Robot dying(folder, "a", camera(1, 100000), with(a, {b, c}, "1"));
  Robot second(folder, "b", camera(2, 60), with(b, {a, c}, "max")),
      third(folder, "c", camera(3, 60), with(c, {a, b}, "max"));
  ASSERT_TRUE(second.says("robot c finished")) << second.log();
  ASSERT_TRUE(test::wait_until([&] { return dying.status("keyframes", 0) >= 12; }, std::chrono::seconds(40)));
  kill(dying.process().pid(), SIGKILL);
  EXPECT_EQ(second.ends(std::chrono::seconds(90)), 3) << second.log();
  EXPECT_EQ(third.ends(std::chrono::seconds(90)), 3) << third.log();
  for (Robot* robot : {&second, &third}) {
    EXPECT_THAT(robot->log(), HasSubstr("waiting for a"));
    EXPECT_THAT(robot->log(), HasSubstr("silent for 1"));
    EXPECT_THAT(robot->log(), HasSubstr("(without a, gone silent)"));
    EXPECT_THAT(robot->log(), HasSubstr("the map is without the rest of a"));
  }
  EXPECT_EQ(test::text_of(second.out() / "global.ply"), test::text_of(third.out() / "global.ply"));
  const auto report = test::read_json(second.out() / "report.json");
  EXPECT_TRUE(report.at("same_map").get<bool>());
  EXPECT_TRUE(std::filesystem::exists(second.out() / "global/c.txt"));
  EXPECT_TRUE(std::filesystem::exists(second.out() / "global/a.txt")) << "what it had told is in the map";
}

TEST(Absent, AStoreThatIsFullIsSaidAndNobodyWaitsForWhatCannotCome) {
  const TempFolder folder;
  const auto config = settings(folder, "[network]\nstore_budget_mb = 1\n");
  const std::string limit = std::to_string(100 * test::kPatience);
  const int code = test::run("onemap-fleet",
                             {"--simulate", "3", "--frames", "120", "--seed", "3", "--speed", "max", "--timeout", limit,
                              "--config", config, "--out", folder / "out"},
                             folder / "fleet.txt");
  const std::string log = test::text_of(folder / "out/robot1/log.txt");
  EXPECT_EQ(code, 3) << test::text_of(folder / "fleet.txt") << log;
  EXPECT_THAT(log, HasSubstr("store"));
  EXPECT_THAT(log, HasSubstr("full"));
  EXPECT_THAT(log, HasSubstr("store_budget_mb"));
  EXPECT_THAT(test::text_of(folder / "fleet.txt"), Not(HasSubstr("not agreed after")));
  EXPECT_TRUE(std::filesystem::exists(folder / "out/robot1/report.json"));
}

TEST(Absent, ARobotWithoutRoomForItsOwnRecordsFinishesWithWhatItsLogHolds) {
  const TempFolder folder;
  const auto a = test::free_port(), b = test::free_port();
  const auto config = settings(folder, "[run]\nlinger_s = 2\n");
  const auto small = folder / "small.toml";
  folder.write("small.toml", "[network]\nstore_budget_mb = 1\n[run]\nlinger_s = 2\n");
  Robot full(folder, "full", camera(1, 400),
             {"--once", "--speed", "max", "--listen", at(a), "--peer", at(b), "--config", small});
  Robot roomy(folder, "roomy", camera(2, 20),
              {"--once", "--speed", "max", "--listen", at(b), "--peer", at(a), "--config", config});
  ASSERT_TRUE(full.says("a record of this robot is left out of the map", std::chrono::seconds(60))) << full.log();
  EXPECT_TRUE(roomy.says("robot full finished", std::chrono::seconds(30))) << roomy.log();
  full.stop();
  EXPECT_THAT(full.log(), HasSubstr("records of this robot: the store had no room"));
  roomy.stop();
}

TEST(Absent, SigtermAtOnceIsUnfinishedAndNotAFailure) {
  const TempFolder folder;
  for (const int wait_ms : {12, 20, 50, 200}) {
    Robot robot(folder, fmt::format("r{}", wait_ms), camera(1, 5000), {"--once", "--listen", "127.0.0.1:0"});
    std::this_thread::sleep_for(std::chrono::milliseconds(wait_ms));
    robot.process().terminate();
    const int code = robot.ends();
    // Before main begins nobody can answer but the kernel.
    if (code == 128 + SIGTERM && robot.log().empty()) continue;
    EXPECT_EQ(code, 3) << wait_ms << " ms: " << robot.log();
  }
}

// The last words of a robot that is stopped reach its neighbours.
TEST(Absent, WhatWasPublishedLastIsHeardBeforeARobotEnds) {
  const TempFolder folder;
  const auto a = test::free_port(), b = test::free_port();
  Robot stopping(folder, "stopping", camera(1, 5000), {"--speed", "1", "--listen", at(a), "--peer", at(b)});
  Robot staying(folder, "staying", camera(2, 5000), {"--speed", "1", "--listen", at(b), "--peer", at(a)});
  ASSERT_TRUE(staying.says("neighbour stopping at " + at(a) + " is heard"));
  ASSERT_TRUE(test::wait_until([&] { return stopping.status("tracked", 0) >= 40; }, std::chrono::seconds(40)));
  EXPECT_EQ(stopping.stop(), 0) << stopping.log();
  EXPECT_TRUE(staying.says("robot stopping finished", std::chrono::seconds(3))) << staying.log();
  staying.stop();
}

}  // namespace
}  // namespace onemap
