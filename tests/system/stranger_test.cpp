// Real daemons with somebody on their network who speaks the protocol and means no good.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mapping/records/finished.hpp"
#include "mapping/records/hello.hpp"
#include "mapping/records/kind.hpp"
#include "mapping/records/solution.hpp"
#include "mapping/records/submap.hpp"
#include "mapping/records/trajectory.hpp"
#include "support/running.hpp"
#include "support/stranger.hpp"

namespace onemap {
namespace {

using mapping::RecordKind;
using test::at;
using test::Robot;
using test::Stranger;
using test::TempFolder;
using testing::HasSubstr;
using testing::Not;
using namespace std::chrono_literals;

constexpr const char* kVictimsCamera = "simulated:living-room?width=320&height=240&robot=1&robots=3&frames=60&seed=3";
constexpr const char* kLongCamera = "simulated:living-room?width=320&height=240&robot=1&robots=3&frames=100000&seed=3";

std::uint16_t kind(RecordKind k) { return static_cast<std::uint16_t>(k); }

mapping::TrajectoryRecord five_poses() {
  mapping::TrajectoryRecord record;
  for (int k = 0; k < 5; ++k) {
    mapping::StampedPose pose;
    pose.time = frame_time_from_ns(k * 1'000'000'000ll);
    pose.T_robot_camera.q_wxyz = {1 << 30, 0, 0, 0};
    record.poses.push_back(pose);
  }
  return record;
}

mapping::SolutionRecord only(const RobotId& robot) {
  mapping::SolutionRecord record;
  record.reference = {robot, 1'800'000'000'000'000'000u};
  record.robots.push_back({record.reference, {}});
  return record;
}

// Decodes to 2 MB, and takes about a kilobyte.
mapping::SubmapRecord large_submap(int number) {
  mapping::SubmapRecord record;
  record.voxel_um = 20000;
  record.truncation_um = 80000;
  for (int i = 0; i < 512; ++i) {
    mapping::SubmapBlock block;
    block.key = {8 * (number % 1000) + i / 64, 8 * (number / 1000) + i / 8 % 8, i % 8};
    block.voxels[0].weight = 1;
    record.blocks.push_back(block);
  }
  return record;
}

// A robot by all that it says: a greeting, poses, a solution for itself alone, a map.
void speak_as(Stranger& stranger, const std::string& name) {
  stranger.write(0, kind(RecordKind::hello), encode(mapping::HelloRecord{name, "evil"}));
  stranger.write(1, kind(RecordKind::trajectory), encode(five_poses()));
  stranger.write(1, kind(RecordKind::solution), encode(only(stranger.id())));
  stranger.write(3, kind(RecordKind::submap), encode(large_submap(0)));
}

struct Victim {
  TempFolder folder;
  std::uint16_t port = test::free_port();
  Robot robot;
  explicit Victim(const std::string& camera = kVictimsCamera, const std::string& speed = "1")
      : robot(folder, "victim", camera, {"--speed", speed, "--listen", at(port)}) {
    EXPECT_TRUE(robot.says("listening at")) << robot.log();
  }
};

std::set<std::string> files_below(const std::filesystem::path& folder) {
  std::set<std::string> all;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    all.insert(std::filesystem::relative(entry.path(), folder).string());
  return all;
}

TEST(StrangerTest, NamesThatAreNoNamesWriteNoFilesAndForgeNoLines) {
  const std::vector<std::string> names{"../../PWNED",    "../trajectory", "a/b", "..", "!\xff\xfe\x1b[31m\nroot: x",
                                       {"victim\0x", 8}, {"\0x", 2}};
  for (const std::string& name : names) {
    Victim victim;
    Stranger stranger(name, victim.port);
    speak_as(stranger, "x");
    stranger.talk(1500ms);
    stranger.talk(200ms);
    const std::string own = [&] {
      EXPECT_TRUE(
          test::wait_until([&] { return victim.robot.status("state", std::string("tracking")) != "tracking"; }, 30s));
      EXPECT_EQ(victim.robot.stop(), 0) << victim.robot.log();
      return test::text_of(victim.robot.out() / "trajectory.txt");
    }();
    const int tracked = victim.robot.status("tracked", 0);
    EXPECT_GT(tracked, 0) << victim.robot.log();
    EXPECT_GE(std::count(own.begin(), own.end(), '\n'), tracked) << "the robot's own trajectory";
    for (const std::string& file : files_below(victim.folder / ""))
      EXPECT_TRUE(file.starts_with("victim")) << file << " was written";
    EXPECT_FALSE(std::filesystem::exists(victim.robot.out() / "global/x.txt"));
    const std::string log = victim.robot.log();
    EXPECT_THAT(log, Not(HasSubstr("\x1b")));
    EXPECT_THAT(log, Not(HasSubstr("\nroot: x")));
    EXPECT_THAT(log, HasSubstr("refused")) << "and it is said";
    test::read_json(victim.robot.out() / "report.json");
  }
}

TEST(StrangerTest, SubmapsThatGrowWhenDecodedCostABoundedAmountOfMemory) {
  const int kMost_mb = test::kPatience == 1 ? 600 : 1500;  // a sanitizer keeps books on every byte
  Victim victim(kLongCamera);
  Stranger stranger("-evil", victim.port);
  speak_as(stranger, "-evil");
  for (int k = 1; k < 1500; ++k) stranger.write(3, kind(RecordKind::submap), encode(large_submap(k)));
  stranger.talk(12s);
  EXPECT_GT(stranger.served(), 1000u) << "the test must have shown them";
  std::this_thread::sleep_for(2s);
  EXPECT_LT(victim.robot.memory_mb(), kMost_mb) << victim.robot.log();
  EXPECT_EQ(victim.robot.stop(), 0) << victim.robot.log();
}

TEST(StrangerTest, ARecordInTheRobotsOwnNameDoesNotEraseIt) {
  for (const std::uint64_t life :
       {~std::uint64_t{0}, std::uint64_t{1} << 62, std::uint64_t{1'900'000'000'000'000'000}}) {
    Victim victim;
    Stranger stranger("-evil", victim.port);
    const RobotId robot = RobotId::from_name("victim");
    stranger.write(robot, life, 0, kind(RecordKind::hello), encode(mapping::HelloRecord{"victim", "evil"}));
    stranger.write(robot, life, 0, kind(RecordKind::finished), encode(mapping::FinishedRecord{}));
    stranger.talk(2s);
    ASSERT_TRUE(
        test::wait_until([&] { return victim.robot.status("state", std::string("tracking")) != "tracking"; }, 30s));
    EXPECT_TRUE(test::wait_until([&] { return !victim.robot.status()["refused"].empty(); }, 20s)) << "and counted";
    EXPECT_EQ(victim.robot.stop(), 0) << victim.robot.log();
    EXPECT_GE(test::lines(victim.robot.out() / "trajectory.txt"), 30u / test::kPatience);
    EXPECT_THAT(victim.robot.log(), Not(HasSubstr("robot victim finished: 0 frames")));
    EXPECT_THAT(victim.robot.log(), testing::ContainsRegex("robot victim finished: [1-9]"));
    EXPECT_THAT(victim.robot.log(), HasSubstr("refused")) << "and it is said";
  }
}

TEST(StrangerTest, RobotsThatAreOnlyHeardOfKeepNobodyFromEnding) {
  TempFolder folder;
  const auto port = test::free_port();
  Robot robot(folder, "victim", kVictimsCamera, {"--once", "--speed", "1", "--listen", at(port), "--linger", "1"});
  ASSERT_TRUE(robot.says("listening at"));
  Stranger stranger("gossip", port);
  stranger.talk(1s);
  for (int k = 0; k < 1100; k += 20) {
    std::vector<comms::RobotStatus> ghosts;
    for (int j = k; j < k + 20; ++j) ghosts.push_back({RobotId::from_name(fmt::format("ghost{}", j)), 5, 1, 0, 0, 0});
    stranger.say([&](auto& out) { out.status(ghosts); });
  }
  stranger.talk(1s);
  EXPECT_EQ(robot.ends(180s), 0) << robot.log() << robot.status();
}

TEST(StrangerTest, WhoeverFillsTheTableKeepsNeitherPeersNorNewcomersOut) {
  TempFolder folder;
  const auto port = test::free_port(), peer = test::free_port();
  Robot victim(folder, "victim", kLongCamera, {"--listen", at(port), "--peer", at(peer)});
  ASSERT_TRUE(victim.says("listening at"));
  std::vector<std::unique_ptr<Stranger>> crowd;
  for (int k = 0; k < 40; ++k) crowd.push_back(std::make_unique<Stranger>(fmt::format("s{}", k), port));
  const auto chatter = [&](int rounds) {
    for (int round = 0; round < rounds; ++round)
      for (auto& stranger : crowd) stranger->talk(10ms);
  };
  chatter(6);
  Robot configured(folder, "configured", kLongCamera, {"--listen", at(peer), "--peer", at(port)});
  Robot newcomer(folder, "newcomer", kLongCamera, {"--listen", "127.0.0.2:0", "--peer", at(port)});
  for (int k = 0; k < 20 && (victim.log().find("robot configured joined") == std::string::npos ||
                             victim.log().find("robot newcomer joined") == std::string::npos);
       ++k)
    chatter(1);
  EXPECT_THAT(victim.log(), HasSubstr("robot configured joined"));
  EXPECT_THAT(victim.log(), HasSubstr("robot newcomer joined"));
  for (Robot* robot : {&victim, &configured, &newcomer}) robot->stop();
}

// A board without a battery clock: its second life begins before its first.
TEST(StrangerTest, AClockThatGoesBackBetweenTwoLivesDoesNotSplitTheTeam) {
  for (const bool keeps_its_counter : {true, false}) {
    TempFolder folder;
    const auto a = test::free_port(), b = test::free_port();
    const auto with = [](std::uint16_t own, std::uint16_t other) {
      return std::vector<std::string>{"--listen", at(own), "--peer", at(other), "--speed", "1"};
    };
    std::filesystem::create_directories(folder / "board");
    const std::uint64_t ahead = 2'500'000'000'000'000'000;  // 2049: the clock was wrong in its first life
    folder.write("board/life", std::to_string(ahead) + "\n");
    Robot staying(folder, "staying", kLongCamera, with(a, b));
    {
      Robot board(folder, "board", kLongCamera, with(b, a));
      ASSERT_TRUE(staying.says("robot board joined")) << staying.log();
      board.process().terminate();
      ASSERT_EQ(board.ends(), 0);
    }
    if (!keeps_its_counter) {  // and its log, by which it would know its former life
      std::filesystem::remove(folder / "board/life");
      std::filesystem::remove_all(folder / "board/log");
    }
    Robot board(folder, "board", kVictimsCamera, with(b, a));
    EXPECT_TRUE(board.says("robot staying joined")) << board.log();
    EXPECT_TRUE(staying.says("robot board finished: ", 40s)) << staying.log() << board.log();
    if (!keeps_its_counter) {
      EXPECT_THAT(board.log(), HasSubstr("neighbours know a later life of board"));
    }
    board.stop();
    staying.stop();
  }
}

}  // namespace
}  // namespace onemap
