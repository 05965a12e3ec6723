// Whole teams of real daemons, started by the real onemap-fleet, with emulated links between them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/program.hpp"
#include "support/trajectory.hpp"

namespace onemap {
namespace {

using test::TempFolder;

int run_fleet(const TempFolder& out, std::vector<std::string> arguments, int timeout_s = 120) {
  arguments.insert(arguments.end(),
                   {"--timeout", std::to_string(test::kPatience * timeout_s), "--out", out.path().string()});
  const int code =
      test::run("onemap-fleet", arguments, out / "fleet.txt", std::chrono::seconds(std::max(240, timeout_s + 20)));
  std::string logs = test::text_of(out / "fleet.txt");
  if (code != 0)
    for (int i = 1; i <= 4; ++i) logs += test::text_of(out / ("robot" + std::to_string(i) + "/log.txt"));
  EXPECT_EQ(code, 0) << logs;
  return code;
}

// The report says one map, and so does every robot's.
void expect_one_map(const TempFolder& out, std::size_t robots) {
  const auto report = test::read_json(out / "report.json");
  EXPECT_TRUE(report.at("same_map").get<bool>());
  ASSERT_EQ(report.at("robots").size(), robots);
  for (const auto& robot : report.at("robots")) {
    EXPECT_EQ(robot.at("map_digest"), report.at("robots").at(0).at("map_digest"));
    EXPECT_NE(robot.at("map_digest"), "0000000000000000");
    EXPECT_GT(robot.at("bytes_received").get<std::uint64_t>(), 10000u);
  }
  const std::string first = test::text_of(out / "robot1/global.ply");
  EXPECT_GT(first.size(), 10000u);
  const std::string plan = test::text_of(out / "robot1/map.pgm");  // none where no floor was seen
  for (std::size_t i = 2; i <= robots; ++i)
    EXPECT_EQ(first, test::text_of(out / ("robot" + std::to_string(i) + "/global.ply"))) << "robot" << i;
  for (std::size_t i = 2; i <= robots; ++i)
    EXPECT_EQ(plan, test::text_of(out / ("robot" + std::to_string(i) + "/map.pgm"))) << "robot" << i;
}

// Error of the trajectories that `knower` holds of the robots, in one frame, against the simulation's truth.
double global_ate(const TempFolder& out, const std::string& knower, const std::vector<std::string>& robots) {
  std::vector<std::pair<std::filesystem::path, std::filesystem::path>> pairs;
  for (const std::string& robot : robots)
    pairs.emplace_back(out / (knower + "/global/" + robot + ".txt"), out / (robot + "/groundtruth.txt"));
  return test::team_ate(pairs);
}

TEST(Team, ThreeRobotsEndWithEqualMaps) {
  const TempFolder out;
  if (run_fleet(out, {"--simulate", "3", "--frames", "90", "--seed", "3"}) != 0) return;
  expect_one_map(out, 3);
  const auto report = test::read_json(out / "report.json");
  for (const auto& robot : report.at("robots")) EXPECT_TRUE(robot.at("in_global_map").get<bool>()) << robot;
  EXPECT_GT(report.at("merge_ms").get<int>(), 0);
  for (const char* knower : {"robot1", "robot2", "robot3"})
    EXPECT_LT(global_ate(out, knower, {"robot1", "robot2", "robot3"}), 0.05) << knower;
  for (const char* file : {"local.png", "local.glb", "global.png", "global.glb", "global.ply", "global.pcd", "map.yaml",
                           "trajectory.txt", "team.png"})
    EXPECT_TRUE(std::filesystem::exists(out / ("robot3/" + std::string(file)))) << file;
  const auto& merges = report.at("merges");
  ASSERT_EQ(merges.size(), 3u);
  for (const auto& merge : merges) {
    EXPECT_TRUE(merge.at("joined").get<bool>()) << merge;
    EXPECT_GT(merge.at("inliers").get<int>(), 30) << merge;
    EXPECT_GT(merge.at("distance_m").get<double>(), 0.1) << "they begin at different places";
  }
  EXPECT_THAT(test::text_of(out / "fleet.txt"), testing::HasSubstr("\nrobot1  robot2 "));
}

// At the recordings' own pace the robots find each other while they still map.
TEST(Team, RobotsMergeWhileTheyMap) {
  const TempFolder out;
  out.write("team.toml", "[run]\nmerge_while_mapping_s = 1\n");
  if (run_fleet(out, {"--simulate", "2", "--frames", "300", "--seed", "3", "--speed", "1", "--config",
                      out / "team.toml"}) != 0)
    return;
  expect_one_map(out, 2);
  const std::string log = test::text_of(out / "robot1/log.txt");
  const std::size_t merged = log.find("robots robot1 robot2"), finished = log.find("robot robot1 finished");
  ASSERT_NE(finished, std::string::npos) << log;
  EXPECT_LT(merged, finished) << log;
}

TEST(Team, LineWithLossEndsWithEqualMaps) {
  const TempFolder out;
  if (run_fleet(out, {"--simulate", "3", "--frames", "60", "--seed", "3", "--graph", "line", "--loss", "20%"}) != 0)
    return;
  expect_one_map(out, 3);
}

TEST(Team, AStrangerRelaysAndStaysOutOfTheMap) {
  const TempFolder out;
  if (run_fleet(out, {"--robot", "simulated:living-room?robot=1&robots=3&frames=90&seed=3", "--robot",
                      "simulated:storage?robot=1&robots=3&frames=90&seed=3", "--robot",
                      "simulated:living-room?robot=2&robots=3&frames=90&seed=3", "--graph", "1-2,2-3"}) != 0)
    return;
  expect_one_map(out, 3);
  const auto robots = test::read_json(out / "report.json").at("robots");
  EXPECT_TRUE(robots.at(0).at("in_global_map").get<bool>());
  EXPECT_FALSE(robots.at(1).at("in_global_map").get<bool>());
  EXPECT_TRUE(robots.at(2).at("in_global_map").get<bool>());
  EXPECT_FALSE(std::filesystem::exists(out / "robot1/global/robot2.txt"));
  EXPECT_THAT(test::text_of(out / "fleet.txt"), testing::HasSubstr("robot1 and robot2 are not joined: "));
  EXPECT_LT(global_ate(out, "robot2", {"robot1", "robot3"}), 0.05) << "the stranger knows the others' map too";
}

TEST(Team, ARobotThatCannotStartEndsTheFleetWithAnError) {
  const TempFolder out;
  EXPECT_EQ(test::run("onemap-fleet",
                      {"--robot", "simulated:office?frames=20", "--robot", "replay:/nonexistent", "--out",
                       out.path().string()},
                      out / "fleet.txt"),
            1);
  EXPECT_THAT(test::text_of(out / "fleet.txt"), testing::HasSubstr("robot2 ended too early"));
}

TEST(Team, RobotsWithoutALinkAreNotOneTeam) {
  const TempFolder out;
  EXPECT_EQ(test::run("onemap-fleet",
                      {"--simulate", "2", "--frames", "20", "--graph", "1-2", "--loss", "0.999", "--timeout", "8",
                       "--out", out.path().string()},
                      out / "fleet.txt"),
            3);
  EXPECT_FALSE(test::read_json(out / "report.json").at("same_map").get<bool>());
}

// The whole way from images to the team's map, in one number: what changes none of the algorithms changes no bit of it.
// The number is a release build's on x86-64; a change of the algorithms takes the new one, and its commit says why.
TEST(Team, FourRobotsAtOneDeskEndWithThePinnedMap) {
  const std::filesystem::path data = std::filesystem::path(ONEMAP_SHARED_DIR) / "data";
  if (!std::filesystem::exists(data / "fr1_xyz") || !std::filesystem::exists(data / "fr1_rpy_a"))
    GTEST_SKIP() << "the recordings fr1_xyz and fr1_rpy_a are not in " << data;
  if (!std::string(ONEMAP_SANITIZE).empty()) GTEST_SKIP() << "four recordings under a sanitizer take too long";
  const TempFolder out;
  const std::string xyz = "replay:" + (data / "fr1_xyz").string(), rpy = "replay:" + (data / "fr1_rpy_a").string();
  if (run_fleet(out,
                {"--robot", xyz + ":0:330", "--robot", xyz + ":230:560", "--robot", xyz + ":460:789", "--robot", rpy,
                 "--graph", "line"},
                400) != 0)
    return;
  expect_one_map(out, 4);
  const auto report = test::read_json(out / "report.json");
  for (const auto& robot : report.at("robots")) {
    EXPECT_TRUE(robot.at("in_global_map").get<bool>()) << robot;
    EXPECT_EQ(robot.at("map_digest"), "54647ecdfb754785");
  }
}

TEST(Team, RecordedCutsOfOneDeskBecomeOneMap) {
  const std::filesystem::path recording = std::filesystem::path(ONEMAP_SHARED_DIR) / "data/fr1_xyz";
  if (!std::filesystem::exists(recording)) GTEST_SKIP() << "the recording " << recording << " is not here";
  const TempFolder out;
  const std::string address = "replay:" + recording.string();
  if (run_fleet(out, {"--robot", address + ":0:120", "--robot", address + ":90:210", "--loss", "10%"}) != 0) return;
  expect_one_map(out, 2);
  const auto report = test::read_json(out / "report.json");
  for (const auto& robot : report.at("robots")) EXPECT_TRUE(robot.at("in_global_map").get<bool>()) << robot;
}

}  // namespace
}  // namespace onemap
