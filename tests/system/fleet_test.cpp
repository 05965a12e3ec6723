// The real onemap-fleet when a robot dies, when it is stopped itself, and what it says of the files that are there.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <optional>
#include <set>

#include "support/running.hpp"

namespace onemap {
namespace {

using test::TempFolder;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using namespace std::chrono_literals;

// The processes that a process started, by number: PID of each, with its command line.
std::map<pid_t, std::string> children_of(pid_t parent) {
  std::map<pid_t, std::string> children;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    const std::string name = entry.path().filename().string();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    const std::string stat = test::text_of(entry.path() / "stat");  // PID (NAME) STATE PARENT ...
    std::istringstream rest(stat.substr(std::min(stat.size(), stat.rfind(')') + 1)));
    std::string state;
    pid_t above = 0;
    if (rest >> state >> above && above == parent && state != "Z")
      children[static_cast<pid_t>(std::stol(name))] = test::text_of(entry.path() / "cmdline");
  }
  return children;
}

std::optional<pid_t> child_named(pid_t parent, const std::string& robot) {
  for (const auto& [pid, command] : children_of(parent))
    if (command.find("--id" + std::string(1, '\0') + robot + std::string(1, '\0')) != std::string::npos) return pid;
  return std::nullopt;
}

// Three robots that walk for long.
class RunningFleet {
 public:
  explicit RunningFleet(const TempFolder& folder)
      : folder_(folder),
        process_(test::start(
            "onemap-fleet",
            {"--simulate", "3", "--frames", "100000", "--seed", "3", "--speed", "1", "--out", folder / "out"},
            folder / "fleet.txt")) {}
  daemon::ChildProcess& process() { return process_; }
  std::string text() const { return test::text_of(folder_ / "fleet.txt"); }
  bool all_track(int frames) {
    return test::wait_until(
        [&] {
          for (const char* robot : {"robot1", "robot2", "robot3"}) {
            const auto file = folder_ / ("out/" + std::string(robot) + "/status.json");
            const auto status = nlohmann::json::parse(test::text_of(file), nullptr, false);
            if (!status.is_object() || status.value("tracked", 0) < frames) return false;
          }
          return true;
        },
        120s);
  }

 private:
  const TempFolder& folder_;
  daemon::ChildProcess process_;
};

TEST(FleetTest, ARobotThatIsKilledEndsTheFleetWhichReportsTheRest) {
  const TempFolder folder;
  RunningFleet fleet(folder);
  ASSERT_TRUE(fleet.all_track(20)) << fleet.text();
  const auto before = children_of(fleet.process().pid());
  EXPECT_EQ(before.size(), 3u);
  const auto victim = child_named(fleet.process().pid(), "robot2");
  ASSERT_TRUE(victim);
  ASSERT_EQ(kill(*victim, SIGKILL), 0);
  ASSERT_TRUE(fleet.process().wait(150s)) << fleet.text();
  EXPECT_EQ(fleet.process().exit_code(), 1) << fleet.text();
  EXPECT_THAT(fleet.text(),
              AllOf(HasSubstr("robot2 ended too early with signal 9"), HasSubstr("robot2/log.txt:\n  robot2: "),
                    HasSubstr("robot2: FAILED: ended too early with signal 9"), HasSubstr("robot1/local.png"),
                    HasSubstr("robot3/local.glb"), Not(HasSubstr("robot2/local.")), HasSubstr("maps equal: NO")));
  const auto report = test::read_json(folder / "out/report.json");
  EXPECT_FALSE(report.at("same_map").get<bool>());
  const auto& robots = report.at("robots");
  ASSERT_EQ(robots.size(), 3u);
  EXPECT_EQ(robots[1].at("name"), "robot2");
  EXPECT_EQ(robots[1].at("failed"), "ended too early with signal 9");
  EXPECT_GE(robots[1].at("tracked").get<int>(), 15) << "what was last known of it";
  for (const int survivor : {0, 2}) {
    EXPECT_FALSE(robots[survivor].contains("failed"));
    EXPECT_GE(robots[survivor].at("tracked").get<int>(), 15);
  }
  for (const auto& [pid, command] : before) EXPECT_NE(kill(pid, 0), 0) << "still runs: " << command;
}

TEST(FleetTest, AStoppedFleetStopsItsRobotsAndReports) {
  for (const int signal : {SIGTERM, SIGINT}) {
    const TempFolder folder;
    RunningFleet fleet(folder);
    ASSERT_TRUE(fleet.all_track(10)) << fleet.text();
    const auto before = children_of(fleet.process().pid());
    EXPECT_EQ(before.size(), 3u);
    ASSERT_EQ(kill(fleet.process().pid(), signal), 0);
    ASSERT_TRUE(fleet.process().wait(150s)) << fleet.text();
    EXPECT_EQ(fleet.process().exit_code(), 3) << fleet.text();
    EXPECT_THAT(fleet.text(), AllOf(HasSubstr("stopped before all agreed"), Not(HasSubstr("FAILED"))));
    EXPECT_EQ(test::read_json(folder / "out/report.json").at("robots").size(), 3u);
    for (const char* robot : {"robot1", "robot2", "robot3"}) {
      EXPECT_GE(test::lines(folder / ("out/" + std::string(robot) + "/trajectory.txt")), 8u) << robot;
      EXPECT_TRUE(std::filesystem::exists(folder / ("out/" + std::string(robot) + "/local.ply"))) << robot;
    }
    for (const auto& [pid, command] : before) EXPECT_NE(kill(pid, 0), 0) << "still runs: " << command;
  }
}

TEST(FleetTest, ARobotThatCannotStartShowsItsLog) {
  const TempFolder folder;
  std::filesystem::create_directories(folder / "out/robot2");
  for (const char* file : {"local.png", "team.png", "matches/000001-000010.png"})
    folder.write("out/robot2/" + std::string(file), "of an earlier run");
  EXPECT_EQ(
      test::run("onemap-fleet",
                {"--robot", "simulated:office?frames=20", "--robot", "replay:/nonexistent", "--out", folder / "out"},
                folder / "fleet.txt"),
      1);
  const std::string text = test::text_of(folder / "fleet.txt");
  EXPECT_THAT(text, AllOf(HasSubstr("robot2 ended too early with exit status 1"),
                          HasSubstr("  robot2: camera address 'replay:/nonexistent': no folder '/nonexistent'"),
                          Not(HasSubstr("robot2/local.png")), Not(HasSubstr("robot2/team.png"))));
  EXPECT_FALSE(std::filesystem::exists(folder / "out/robot2/matches"));
  const auto report = test::read_json(folder / "out/report.json");
  EXPECT_EQ(report.at("robots").at(1).at("failed"), "ended too early with exit status 1");
  EXPECT_EQ(report.at("robots").at(1).at("camera"), "replay:/nonexistent");
}

TEST(FleetTest, WrongCommandLinesAndConfigurationsStartNothing) {
  const TempFolder folder;
  folder.write("nan.toml", "[map]\nvoxel_m = nan\n");
  const std::vector<std::pair<std::vector<std::string>, std::string>> wrong{
      {{"--config", folder / "nan.toml"}, "nan.toml:2: map.voxel_m"},
      {{"--config", folder.path().string()}, "cannot read: Is a directory"},
      {{"--delay", "nan"}, "--delay"},
      {{"--timeout", "nan"}, "--timeout"},
      {{"--loss", "nan"}, "loss 'nan'"},
      {{"--speed", "nan"}, "speed 'nan'"},
      {{"--scene", "attic"}, "no scene 'attic'"},
  };
  for (const auto& [more, why] : wrong) {
    std::vector<std::string> arguments{"--simulate", "2", "--out", folder / "out"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    EXPECT_EQ(test::run("onemap-fleet", arguments, folder / "fleet.txt"), 2) << test::text_of(folder / "fleet.txt");
    EXPECT_THAT(test::text_of(folder / "fleet.txt"), HasSubstr(why));
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

std::size_t vertices_of(const std::filesystem::path& ply) {
  const std::string head = test::text_of(ply).substr(0, 2000), word = "element vertex ";
  const std::size_t at = head.find(word);
  return at == std::string::npos ? 0 : std::stoul(head.substr(at + word.size()));
}

TEST(FleetTest, GlobalPointsAreWhatTheFilesHoldAndWhatIsMissingIsSaid) {
  const TempFolder folder;
  folder.write("small.toml", "[map]\nbudget_mb = 4\n");
  const std::vector<std::string> arguments{
      "--simulate", "2", "--frames", "40", "--seed", "3", "--config", folder / "small.toml", "--out", folder / "out"};
  ASSERT_EQ(test::run("onemap-fleet", arguments, folder / "fleet.txt"), 0) << test::text_of(folder / "fleet.txt");
  const auto report = test::read_json(folder / "out/report.json");
  const auto points = report.at("global_points").get<std::size_t>();
  EXPECT_GT(points, 1000u);
  for (const char* robot : {"robot1", "robot2"})
    EXPECT_EQ(vertices_of(folder / ("out/" + std::string(robot) + "/global.ply")), points) << robot;
  const std::string text = test::text_of(folder / "fleet.txt");
  EXPECT_THAT(text, HasSubstr(std::to_string(points) + " points"));
  const auto refused = report.at("robots").at(0).at("blocks_refused").get<std::uint64_t>();
  ASSERT_GT(refused, 0u) << "the test wants a map that is too small";
  EXPECT_THAT(text, HasSubstr("robot1: no room for " + std::to_string(refused) + " blocks of the local map"));
  EXPECT_GT(test::read_json(folder / "out/robot1/status.json").at("blocks_refused").get<std::uint64_t>(), 0u);
}

}  // namespace
}  // namespace onemap
