// What may go wrong around a daemon: it says what, counts it, and goes on.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/other_program.hpp"
#include "support/running.hpp"
#include "support/team_key.hpp"

namespace onemap {
namespace {

using namespace std::chrono_literals;
using test::Robot;
using test::TempFolder;
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

// Programs in namespaces of their own, with what a shell does there first.
class Walled {
 public:
  Walled(const TempFolder& folder, const std::string& walls, const std::string& first, const std::string& camera,
         const std::string& more, const std::string& id = "robot")
      : out_(folder / "out"), log_(folder / "log.txt") {
    fs::create_directories(out_);
    const std::string script = fmt::format("{}\nexec {}/onemapd --id {} --camera '{}' --out {} {}", first,
                                           ONEMAP_BIN_DIR, id, camera, out_.string(), more);
    auto child = daemon::ChildProcess::start("/usr/bin/unshare", {walls, "bash", "-e", "-c", script}, log_.string());
    if (child) process_.emplace(std::move(*child));
  }
  // Why it cannot be tried here; empty: it can.
  static std::string missing(const std::string& walls) {
    const auto said = test::say("unshare " + walls + " true");
    return said.status == 0 ? "" : "no namespaces here (needs root): " + said.output;
  }
  daemon::ChildProcess& process() { return *process_; }
  std::string log() const { return test::text_of(log_); }
  bool says(const std::string& words) {
    return test::wait_until([&] { return log().find(words) != std::string::npos; }, 60s);
  }
  // A file of its world.
  fs::path in_there(const std::string& name) const {
    return fmt::format("/proc/{}/root{}/{}", process_->pid(), out_.string(), name);
  }
  // What a shell does in its world; its exit status.
  int within(const std::string& command) const {
    return test::say(fmt::format("nsenter -t {} -m -n sh -c '{}'", process_->pid(), command)).status;
  }
  nlohmann::json status() const {
    return nlohmann::json::parse(test::text_of(in_there("status.json")), nullptr, false);
  }
  std::uint64_t frames() const {
    const auto now = status();
    return now.is_object() ? now.value("frames", 0u) : 0;
  }
  bool goes_on() {
    const auto before = frames();
    return test::wait_until([&] { return frames() > before + 5; }, 60s);
  }
  int stop() {
    process_->terminate();
    return process_->wait(test::kPatience * 60s) ? process_->exit_code() : -1;
  }
  const fs::path& out() const { return out_; }

 private:
  fs::path out_, log_;
  std::optional<daemon::ChildProcess> process_;
};

constexpr const char* kLongWalk = "simulated:living-room?seed=3&frames=100000";

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

TEST(Disk, AStateThatCannotBeReadIsSetAside) {
  const TempFolder folder;
  folder.write("robot/life", "\x01\x02 not a number");
  Robot robot(folder, "robot", "simulated:living-room?seed=3&frames=30", {"--once", "--speed", "max"});
  EXPECT_EQ(robot.ends(), 0) << robot.log();
  EXPECT_THAT(robot.log(), HasSubstr("set aside as " + (robot.out() / "life.corrupt-1").string()));
  EXPECT_EQ(test::text_of(robot.out() / "life.corrupt-1"), "\x01\x02 not a number");
}

TEST(Network, NoneAtAllIsWaitedForAndTheRobotMaps) {
  if (const auto missing = Walled::missing("-n"); !missing.empty()) GTEST_SKIP() << missing;
  const TempFolder folder;
  folder.write("robot.toml",
               "[network]\nlisten = \"0.0.0.0:4600\"\npeers = [\"10.7.0.2:4600\"]\n[team]\nkey_file = \"" +
                   test::team_key(folder) + "\"\n");
  Walled robot(folder, "-n", "", kLongWalk, "--config " + (folder / "robot.toml"));
  ASSERT_TRUE(test::wait_until([&] { return robot.frames() > 20; }, 60s)) << robot.log();
  EXPECT_TRUE(robot.says("nothing can be sent: is there a network")) << robot.log();
  EXPECT_EQ(robot.within("ip link set lo up && ip addr add 10.7.0.1/24 dev lo"), 0);
  EXPECT_TRUE(robot.says("the network takes datagrams again")) << robot.log();
  EXPECT_TRUE(robot.goes_on());
  EXPECT_EQ(robot.stop(), 0) << robot.log();
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
  const std::string walk = "simulated:living-room?seed=3&robots=2&frames=100000&robot=";
  Walled a(a_folder, "-n", wait, walk + "1", settings(a_folder, "10.7.0.2"), "a");
  Walled b(b_folder, "-n", wait, walk + "2", settings(b_folder, "10.7.0.1"), "b");
  const std::string cable = fmt::format("om{}", getpid());
  const auto plug = test::say(fmt::format(
      "sleep 1; ip link add {0}a type veth peer name {0}b && ip link set {0}a netns {1} name eth0 && ip link set {0}b "
      "netns {2} name eth0",
      cable, a.process().pid(), b.process().pid()));
  if (plug.status != 0) GTEST_SKIP() << "no cables between namespaces here: " << plug.output;
  for (const auto& [robot, address] : {std::pair(&a, "10.7.0.1/24"), std::pair(&b, "10.7.0.2/24")})
    ASSERT_EQ(robot->within(fmt::format("ip link set lo up; ip link set eth0 up; ip addr add {} dev eth0", address)),
              0);
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
