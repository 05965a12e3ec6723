// What may go wrong around a daemon: it says what, counts it, and goes on.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/other_program.hpp"
#include "support/walled.hpp"

namespace onemap {
namespace {

using namespace std::chrono_literals;
using test::Robot;
using test::TempFolder;
using test::Walled;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
namespace fs = std::filesystem;

constexpr const char* kWalk = "simulated:living-room?seed=3&frames=150";

// The last frame that has a place in the way, counted from the start of the walk (30 Hz).
double last_placed_frame(const Robot& robot) {
  const auto lines = test::lines_of(robot.out() / "trajectory.txt");
  return lines.empty() ? -1 : (std::stod(lines.back()) - 1.6e9) * 30;
}

class CameraFault : public testing::Test {
 public:
  // The robot at the end of a walk with a fault, all frames mapped and everything written.
  Robot& walk(const std::string& fault) {
    robot_.emplace(folder_, "robot", kWalk + std::string("&") + fault,
                   std::vector<std::string>{"--once", "--speed", "max"});
    EXPECT_EQ(robot_->ends(300s), 0) << robot_->log();
    return *robot_;
  }

 private:
  const TempFolder folder_;
  std::optional<Robot> robot_;
};

TEST_F(CameraFault, UnpluggedAndBack) {
  const Robot& robot = walk("unplug_at=60&back_after=15");
  EXPECT_THAT(robot.log(), AllOf(HasSubstr("the camera is gone: simulated living-room: unplugged"),
                                 HasSubstr("the camera is back"), HasSubstr("the camera went away 1 times")));
  EXPECT_GT(last_placed_frame(robot), 140);
}

TEST_F(CameraFault, FrozenFramesAreNotAPlace) {
  const Robot& robot = walk("freeze_at=60&fault_for=30");
  EXPECT_THAT(robot.log(),
              AllOf(HasSubstr("shows the same picture again and again"),
                    HasSubstr("its pictures change again, after 30 frames"), HasSubstr("30 like the one before")));
  EXPECT_GT(last_placed_frame(robot), 140);
  const auto lines = test::lines_of(robot.out() / "trajectory.txt");
  const auto frozen = std::ranges::count_if(lines, [](const std::string& line) {
    const double frame = (std::stod(line) - 1.6e9) * 30;
    return frame > 70 && frame < 89;
  });
  EXPECT_EQ(frozen, 0) << "it does not stand where it stood";
}

TEST_F(CameraFault, BlackFrames) {
  const Robot& robot = walk("black_at=60&fault_for=30");
  EXPECT_THAT(robot.log(), AllOf(HasSubstr("the camera's pictures are black: is its lens covered"),
                                 HasSubstr("no more black, after 30 frames"), HasSubstr("30 black")));
  EXPECT_GT(last_placed_frame(robot), 140);
}

TEST_F(CameraFault, SaturatedFrames) {
  const Robot& robot = walk("saturate_at=60&fault_for=30");
  EXPECT_THAT(robot.log(), AllOf(HasSubstr("the camera's pictures are white"),
                                 HasSubstr("no more white, after 30 frames"), HasSubstr("30 white")));
  EXPECT_GT(last_placed_frame(robot), 140);
}

TEST_F(CameraFault, NoDepth) {
  const Robot& robot = walk("no_depth_at=60&fault_for=30");
  EXPECT_THAT(robot.log(), AllOf(HasSubstr("the camera has no depth"), HasSubstr("it has depth again, after 30 frames"),
                                 HasSubstr("30 without depth")));
  EXPECT_GT(last_placed_frame(robot), 140);
}

TEST_F(CameraFault, AFocalLengthThatIsWrongIsMeasuredAndSaid) {
  const Robot& robot = walk("fx_scale=1.25");
  EXPECT_THAT(robot.log(), testing::ContainsRegex("the focal length is 1\\.2[0-9] of what fits [0-9]+ pairs of views"));
}

TEST_F(CameraFault, TimeThatGoesBackAndReturns) {
  const Robot& robot = walk("time_back_at=60&fault_for=30");
  EXPECT_THAT(robot.log(), AllOf(HasSubstr("frame 60 refused: its time, 1599996402.000 s"),
                                 HasSubstr("set back: its times are moved by"), HasSubstr("its times are its own"),
                                 HasSubstr("10 back in time")));
  EXPECT_GT(last_placed_frame(robot), 140);
}

TEST_F(CameraFault, TimeThatGoesBackForGood) {
  const Robot& robot = walk("time_back_at=60");
  EXPECT_THAT(robot.log(), HasSubstr("set back: its times are moved by"));
  EXPECT_GT(last_placed_frame(robot), 130) << "moved to where they were, less ten frames";
  const auto lines = test::lines_of(robot.out() / "trajectory.txt");
  for (std::size_t i = 1; i < lines.size(); ++i) ASSERT_LT(std::stod(lines[i - 1]), std::stod(lines[i]));
}

constexpr const char* kLongWalk = "simulated:living-room?seed=3&frames=100000&width=320&height=240";

TEST(Disk, AFullOneIsSaidOnceAndTheDaemonGoesOn) {
  if (const auto missing = Walled::missing("-m"); !missing.empty()) GTEST_SKIP() << missing;
  const TempFolder folder;
  folder.write("robot.toml", "[record]\nstart = true\nleast_free_mb = 0\n");
  Walled robot(folder, "-m", "mount -t tmpfs -o size=30m none " + (folder / "out"), kLongWalk,
               "--config " + (folder / "robot.toml"));
  ASSERT_TRUE(robot.says("the recording ended after ")) << "it fills the disk" << robot.log();
  EXPECT_THAT(robot.log(), HasSubstr("No space left on device"));
  // What the recording's last picture left is filled, too.
  robot.within("head -c 30000000 /dev/zero > " + robot.out().string() + "/filler");
  ASSERT_TRUE(robot.says("status.json")) << robot.log();
  EXPECT_EQ(robot.within("rm -r " + robot.out().string() + "/filler " + robot.out().string() + "/recordings"), 0);
  ASSERT_TRUE(robot.says("status.json is written again")) << robot.log();
  EXPECT_TRUE(robot.goes_on()) << robot.log();
  EXPECT_EQ(robot.stop(), 0) << robot.log();
  const std::string log = robot.log();
  EXPECT_EQ(log.find("status.json: cannot write"), log.rfind("status.json: cannot write")) << "once: " << log;
}

TEST(Disk, OneThatBecomesReadOnlyIsSaidAndTheDaemonGoesOn) {
  if (const auto missing = Walled::missing("-m"); !missing.empty()) GTEST_SKIP() << missing;
  const TempFolder folder;
  const std::string out = folder / "out";
  // With a file open for writing, as the log's is, nobody makes a disk read-only but a kernel that finds it failing.
  folder.write("robot.toml", "[store]\nkeep = false\n");
  Walled robot(folder, "-m", "mount -t tmpfs -o size=100m none " + out, kLongWalk,
               "--config " + (folder / "robot.toml"));
  ASSERT_TRUE(test::wait_until([&] { return robot.frames() > 5; }, 60s)) << robot.log();
  ASSERT_TRUE(test::wait_until([&] { return robot.within("mount -o remount,ro " + out) == 0; }, 20s));
  ASSERT_TRUE(robot.says("Read-only file system")) << robot.log();
  ASSERT_TRUE(test::wait_until([&] { return robot.within("mount -o remount,rw " + out) == 0; }, 20s));
  ASSERT_TRUE(robot.says("status.json is written again")) << robot.log();
  EXPECT_TRUE(robot.goes_on());
  EXPECT_EQ(robot.stop(), 0) << robot.log();
}

// The kernel's own answer to a disk that fails, under the log's open file; there is no way back without a new mount.
TEST(Disk, OneThatFailsUnderTheLogIsSaidAndTheDaemonGoesOn) {
  const TempFolder folder;
  const std::string out = folder / "out", image = folder / "disk";
  const std::string mount = fmt::format("mount -t ext4 -o loop,errors=remount-ro {} ", image);
  const auto made = test::say(fmt::format("truncate -s 64M {} && /sbin/mkfs.ext4 -q {} && mkdir {} && unshare -m {}{}",
                                          image, image, folder / "try", mount, folder / "try"));
  if (made.status != 0) GTEST_SKIP() << "no disk of our own here (needs root, e2fsprogs, loop): " << made.output;
  Walled robot(folder, "-m", mount + out, kLongWalk, "");
  const auto frames = [&] {
    const auto said = test::say(fmt::format("nsenter -t {} -m {}/onemapctl --socket {}/control.sock --json status",
                                            robot.process().pid(), ONEMAP_BIN_DIR, out));
    const auto now = nlohmann::json::parse(said.output, nullptr, false);
    return now.is_object() ? now.value("frames", 0u) : 0u;
  };
  ASSERT_TRUE(test::wait_until([&] { return frames() > 5; }, 60s)) << robot.log();
  ASSERT_TRUE(test::wait_until([&] { return fs::exists(robot.in_there("log/lock")); }, 60s)) << robot.log();
  ASSERT_EQ(robot.within("echo a test > /sys/fs/ext4/$(basename $(findmnt -no SOURCE " + out + "))/trigger_fs_error"),
            0);
  ASSERT_TRUE(robot.says("out/log: the disk cannot be written to; the robot goes on")) << robot.log();
  ASSERT_TRUE(robot.says("status.json: cannot write: Read-only file system")) << robot.log();
  const unsigned before = frames();
  EXPECT_TRUE(test::wait_until([&] { return frames() > before + 20; }, 60s)) << robot.log();
  EXPECT_EQ(robot.stop(), 1) << "what it should write at the end is not written\n" << robot.log();
  const std::string log = robot.log(), said = "the disk cannot be written to";
  EXPECT_EQ(log.find(said), log.rfind(said)) << "once: " << log;
  EXPECT_THAT(log, Not(HasSubstr("store_budget_mb"))) << "which would not help";
}

TEST(Disk, ALimitOfTheFileSizeDoesNotKillIt) {
  const TempFolder folder;
  const auto said =
      test::say(fmt::format("bash -c \"ulimit -f 40; exec {}/onemapd --camera '{}' --once --speed max --out {}\"",
                            ONEMAP_BIN_DIR, "simulated:living-room?seed=3&frames=30", folder / "out"));
  EXPECT_EQ(said.status, 1) << said.output;
  EXPECT_THAT(said.output,
              HasSubstr("not written: " + (folder / "out/local.drawing.omap") + ": cannot write: File too"));
  EXPECT_TRUE(fs::exists(folder / "out/report.json")) << "what is small enough is written";
}

// Somebody empties the log's files under the daemon, which reads voxels from them when it fuses them anew.
TEST(Disk, WhatIsTakenFromTheLogIsSaidAndTheDaemonGoesOn) {
  const TempFolder folder;
  Robot robot(folder, "robot", kLongWalk, {"--speed", "max"});
  const auto frames = [&] { return robot.status("frames", 0u); };
  ASSERT_TRUE(test::wait_until([&] { return frames() > 100; }, 60s)) << robot.log();
  ASSERT_THAT(robot.log(), Not(HasSubstr("cannot be read where it is kept")));
  const auto empty = [&] {  // again and again: what is new is fused from there soon
    for (const auto& entry : fs::directory_iterator(robot.out() / "log"))
      if (entry.path().filename() != "lock") fs::resize_file(entry.path(), 0);
    return robot.log().find("its body cannot be read where it is kept: the map has there what it had") !=
           std::string::npos;
  };
  ASSERT_TRUE(test::wait_until(empty, 60s)) << robot.log();
  const unsigned before = frames();
  EXPECT_TRUE(test::wait_until([&] { return frames() > before + 20; }, 60s)) << robot.log();
  EXPECT_TRUE(test::wait_until(
      [&] { return robot.status("refused", nlohmann::json::object()).value("submap_unread", 0u) > 0; }, 60s))
      << test::text_of(robot.out() / "status.json");
  EXPECT_NE(robot.stop(), -1) << robot.log();
}

TEST(Disk, AStateThatCannotBeReadIsSetAside) {
  const TempFolder folder;
  folder.write("robot/life", "\x01\x02 not a number");
  Robot robot(folder, "robot", "simulated:living-room?seed=3&frames=30", {"--once", "--speed", "max"});
  EXPECT_EQ(robot.ends(), 0) << robot.log();
  EXPECT_THAT(robot.log(), HasSubstr("set aside as " + (robot.out() / "life.corrupt-1").string()));
  EXPECT_EQ(test::text_of(robot.out() / "life.corrupt-1"), "\x01\x02 not a number");
}

}  // namespace
}  // namespace onemap
