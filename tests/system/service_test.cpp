// The real daemon and what a service manager hears of it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <thread>

#include "support/notify_socket.hpp"
#include "support/program.hpp"

namespace onemap {
namespace {

using namespace std::chrono_literals;
using daemon::ChildProcess;
using test::kPatience;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

class SystemService : public testing::Test {
 protected:
  SystemService() {
    ::setenv("NOTIFY_SOCKET", socket_.name().c_str(), 1);
    ::setenv("WATCHDOG_USEC", "2000000", 1);
    ::setenv("STATE_DIRECTORY", (folder_ / "state").c_str(), 1);
    ::setenv("RUNTIME_DIRECTORY", (folder_ / "run").c_str(), 1);
  }
  ~SystemService() override {
    for (const char* name : {"NOTIFY_SOCKET", "WATCHDOG_USEC", "STATE_DIRECTORY", "RUNTIME_DIRECTORY"})
      ::unsetenv(name);
  }
  ChildProcess start(const std::string& camera) {
    return test::start("onemapd", {"--config", "/dev/null", "--id", "anna", "--camera", camera}, folder_ / "log");
  }
  // The next message that begins so; what came before it is in earlier_.
  std::string await(const std::string& begin) {
    while (auto text = socket_.next(kPatience * 20s)) {
      if (text->starts_with(begin)) return *text;
      earlier_.push_back(*text);
    }
    ADD_FAILURE() << "never said " << begin << "; the log:\n" << test::text_of(folder_ / "log");
    return {};
  }
  const test::TempFolder folder_;
  test::NotifySocket socket_{folder_ / "notify"};
  std::vector<std::string> earlier_;
};

TEST_F(SystemService, IsReadyThenWatchedAndSaysThatItStops) {
  ChildProcess robot = start("simulated:office?width=320&height=240&frames=1000000");
  await("READY=1");
  EXPECT_TRUE(earlier_.empty()) << "nothing before it is ready";
  await("WATCHDOG=1");
  await("STATUS=tracking: ");
  EXPECT_TRUE(std::filesystem::exists(folder_ / "state/life")) << "the state folder is where it writes";
  robot.terminate();
  await("STOPPING=1");
  ASSERT_TRUE(robot.wait(kPatience * 60s));
  EXPECT_EQ(robot.exit_code(), 0);
}

// Its whole state is on the disk, and what takes long is left out.
TEST_F(SystemService, AQuickStopKeepsTheMapAndDrawsNothing) {
  const std::vector<std::string> arguments{"--config",
                                           "/dev/null",
                                           "--id",
                                           "anna",
                                           "--quick-stop",
                                           "--camera",
                                           "simulated:office?width=320&height=240&frames=1000000"};
  ChildProcess robot = test::start("onemapd", arguments, folder_ / "log");
  await("READY=1");
  const auto has_map = [](const std::string& status) {  // one with something in it
    return status.find("robots in the map") != std::string::npos && status.find(" 0 keyframes") == std::string::npos;
  };
  while (!has_map(await("STATUS=")) && !HasFailure()) {
  }
  robot.terminate();
  ASSERT_TRUE(robot.wait(kPatience * 60s));
  EXPECT_EQ(robot.exit_code(), 0);
  const std::string state = folder_ / "state";
  EXPECT_GE(test::lines(state + "/trajectory.txt"), 1u);
  for (const char* slow : {"/local.png", "/local.glb"})  // map.pgm may be of the map that was settled before
    EXPECT_FALSE(std::filesystem::exists(state + slow)) << slow;
  const std::string pointer = test::text_of(state + "/settled-map"), digest = pointer.substr(0, pointer.find(' '));
  EXPECT_EQ(
      test::run("onemap-view", {state + "/map-" + digest + ".omap", "--ply", folder_ / "map.ply"}, folder_ / "said"), 0)
      << "what is kept can be looked at";

  // The next life knows of it; one that was changed meanwhile is set aside.
  for (const bool spoilt : {false, true}) {
    if (spoilt) folder_.write("state/map-" + digest + ".omap", "spoilt");
    ChildProcess next = test::start("onemapd", arguments, folder_ / "log");
    await("READY=1");
    next.kill();
    EXPECT_THAT(
        test::text_of(folder_ / "log"),
        HasSubstr(spoilt ? "map-" + digest + ".omap: the kept map is not the one that was written; set aside as "
                         : "the last map of an earlier life is " + state + "/map-" + digest + ".omap"));
  }
}

// Killed at any moment, it has a map that is at most half a minute old.
TEST_F(SystemService, TheMapIsKeptWhileItWorks) {
  ChildProcess robot = start("simulated:office?width=320&height=240&frames=1000000");
  const std::string pointer = folder_ / "state/settled-map";
  for (int i = 0; i < 1200 * kPatience && !std::filesystem::exists(pointer); ++i) std::this_thread::sleep_for(50ms);
  robot.kill();
  const std::string text = test::text_of(pointer), digest = text.substr(0, text.find(' '));
  ASSERT_EQ(digest.size(), 16u) << test::text_of(folder_ / "log");
  const std::string map = folder_ / ("state/map-" + digest + ".omap");
  EXPECT_EQ(test::run("onemap-view", {map, "--ply", folder_ / "map.ply"}, folder_ / "said"), 0);
}

TEST_F(SystemService, WithoutACameraItIsNeverReadyAndSaysWhy) {
  ChildProcess robot = start("replay:/nonexistent");
  EXPECT_THAT(await("STATUS="), HasSubstr("/nonexistent"));
  ASSERT_TRUE(robot.wait(kPatience * 20s));
  EXPECT_EQ(robot.exit_code(), 1);
  EXPECT_TRUE(earlier_.empty());
  EXPECT_FALSE(socket_.next(0ms));
}

// What cannot be asked is not up. Where it would be is a file that is none of ours.
TEST_F(SystemService, WithoutAControlSocketItIsNeverReadyAndSaysWhy) {
  folder_.write("run/control.sock", "no socket");
  const std::string camera = "simulated:office?width=320&height=240&frames=1000000";
  ChildProcess robot = start(camera);
  EXPECT_THAT(await("STATUS="), AllOf(HasSubstr("run/control.sock"), HasSubstr("control.socket")));
  ASSERT_TRUE(robot.wait(kPatience * 20s));
  EXPECT_EQ(robot.exit_code(), 1);
  EXPECT_TRUE(earlier_.empty()) << "never READY=1";
  EXPECT_EQ(test::text_of(folder_ / "run/control.sock"), "no socket") << "what is another's stays";
  std::filesystem::remove(folder_ / "run/control.sock");
  ChildProcess next = start(camera);
  await("READY=1");
  EXPECT_TRUE(std::filesystem::is_socket(folder_ / "run/control.sock"));
}

TEST_F(SystemService, ReadsItsConfigurationAgainAndSaysWhatWaits) {
  folder_.write("c.toml", "[run]\nlinger_s = 3\n");
  ChildProcess robot = test::start("onemapd",
                                   {"--config", folder_ / "c.toml", "--id", "anna", "--camera",
                                    "simulated:office?width=320&height=240&frames=1000000"},
                                   folder_ / "log");
  await("READY=1");
  folder_.write("c.toml", "[run]\nlinger_s = 4\n[map]\nvoxel_m = 0.03\n");
  ASSERT_EQ(::kill(robot.pid(), SIGHUP), 0);
  EXPECT_THAT(await("RELOADING=1"), HasSubstr("\nMONOTONIC_USEC="));
  await("READY=1");
  folder_.write("c.toml", "[run]\nlinger = 4\n");
  ASSERT_EQ(::kill(robot.pid(), SIGHUP), 0);
  await("RELOADING=1");
  await("READY=1");
  robot.terminate();
  ASSERT_TRUE(robot.wait(kPatience * 60s));
  EXPECT_EQ(robot.exit_code(), 0);
  EXPECT_THAT(test::text_of(folder_ / "log"),
              AllOf(HasSubstr("run.linger_s is 4 now, was 3; only a restart changes map.voxel_m (0.03 after 0.02)"),
                    HasSubstr("the configuration is as it was: "), HasSubstr("c.toml:2: unknown key 'linger'")));
}

}  // namespace
}  // namespace onemap
