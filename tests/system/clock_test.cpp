// Clocks that do what no clock should, and robots whose own time stood still.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <fstream>

#include "support/control_talk.hpp"
#include "support/running.hpp"

namespace onemap {
namespace {

using namespace std::chrono_literals;
using test::at;
using test::kSanitized;
using test::Robot;
using test::TempFolder;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kSkipped = "sanitizers want to be loaded before anything else";

// The wall clock says when something was; nothing waits by it.
TEST(Clock, AWallClockThatJumpsByAnHourChangesNothing) {
  if (kSanitized) GTEST_SKIP() << kSkipped;
  const TempFolder folder;
  const auto pa = test::free_port(), pb = test::free_port();
  const auto arguments = [&](int number, const std::string& jump, int own, int other) {
    const std::string id(1, static_cast<char>('a' + number - 1));
    return std::vector<std::string>{
        "LD_PRELOAD=" ONEMAP_BIN_DIR "/clock_jump.so",
        "CLOCK_JUMP_AFTER_S=4",
        "CLOCK_JUMP_S=" + jump,
        ONEMAP_BIN_DIR "/onemapd",
        "--id",
        id,
        "--out",
        folder / id,
        "--camera",
        fmt::format("simulated:living-room?width=320&height=240&seed=3&robots=2&frames=240&robot={}", number),
        "--once",
        "--listen",
        fmt::format("127.0.0.1:{}", own),
        "--peer",
        fmt::format("127.0.0.1:{}", other)};
  };
  auto a = daemon::ChildProcess::start("/usr/bin/env", arguments(1, "3600", pa, pb), folder / "a.log");
  auto b = daemon::ChildProcess::start("/usr/bin/env", arguments(2, "-3600", pb, pa), folder / "b.log");
  ASSERT_TRUE(a && b);
  for (auto* robot : {&*a, &*b}) {
    EXPECT_TRUE(robot->wait(test::kPatience * 200s));
    EXPECT_EQ(robot->exit_code(), 0);
  }
  for (const std::string name : {"a", "b"}) {
    EXPECT_THAT(
        test::text_of(folder / (name + ".log")),
        AllOf(HasSubstr("all 2 robots hold the map"), Not(HasSubstr("fell silent")), Not(HasSubstr("not waited for"))));
    EXPECT_GT(test::lines(folder / (name + "/trajectory.txt")), 50u) << "a busy machine may miss some frames";
  }
}

// What programs that are started meanwhile find in their environment.
class Environment {
 public:
  explicit Environment(std::map<std::string, std::string> values) : values_(std::move(values)) {
    for (const auto& [name, value] : values_) ::setenv(name.c_str(), value.c_str(), 1);
  }
  ~Environment() {
    for (const auto& [name, value] : values_) ::unsetenv(name.c_str());
  }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

 private:
  const std::map<std::string, std::string> values_;
};

// Two robots of one room that never finish, each with its control socket.
struct Pair : testing::Test {
  const TempFolder folder;
  const std::array<std::uint16_t, 2> ports{test::free_port(), test::free_port()};

  std::string socket(const Robot& robot) const { return robot.out() / "control.sock"; }
  Robot start(std::size_t i) {
    const std::string id(1, static_cast<char>('a' + i));
    folder.write(id + ".toml",
                 fmt::format("[run]\nlost_after_s = 8\nmerge_while_mapping_s = 1\n[control]\nsocket = \"{}\"\n",
                             folder / id + "/control.sock"));
    return Robot(
        folder, id,
        fmt::format("simulated:living-room?seed=3&robots=5&frames=100000&width=320&height=240&robot={}", i + 1),
        {"--speed", "0.3", "--listen", at(ports[i]), "--peer", at(ports[1 - i]), "--config", folder / (id + ".toml")});
  }
  static bool agree(const Robot& a, const Robot& b) {
    const auto holds = [](const Robot& r) {
      return r.status("map_agreed", false) && r.status("robots_in_map", 0) == 2;
    };
    return test::wait_until([&] { return holds(a) && holds(b); }, 150s);
  }
};

// The next event of this name about the robot comes.
bool hears(test::Talk& events, const std::string& name, const std::string& robot) {
  for (;;) {
    const auto event = events.hear_class("EVENT", 60s);
    if (!event.is_object()) return false;
    if (event.value("event", "") == name && event.value("robot", "") == robot) return true;
  }
}

// What a minute more does to a robot, without the minute: while it is stopped both of its clocks are set on by 60 s,
// which is all that it can know of the stop. Its neighbour really waits, with a patience of eight seconds.
TEST_F(Pair, ARobotThatWasStoppedForAMinuteGoesOnInTheSameMap) {
  if (kSanitized) GTEST_SKIP() << kSkipped;
  const std::string clock = folder / "clock";
  folder.write("clock", std::string(sizeof(std::int64_t), '\0'));
  Robot a = start(0);
  Robot b = [&] {
    const Environment preloaded({{"LD_PRELOAD", ONEMAP_BIN_DIR "/long_stop.so"}, {"CLOCK_AHEAD", clock}});
    return start(1);
  }();
  ASSERT_TRUE(agree(a, b)) << a.log() << b.log();
  test::Talk events(socket(a));
  events.ask(R"({"class":"WATCH","classes":["EVENT"]})");
  ASSERT_TRUE(events.hear_class("WATCH").is_object());
  kill(b.process().pid(), SIGSTOP);
  ASSERT_TRUE(hears(events, "robot_gone", "b")) << a.log();
  const auto keyframes = b.status("keyframes", 0);
  const auto map = b.status("map_digest", std::string());
  const std::string life = test::text_of(b.out() / "life");
  const std::int64_t minute_s = 60;
  std::fstream(clock, std::ios::in | std::ios::out | std::ios::binary)
      .write(reinterpret_cast<const char*>(&minute_s), sizeof minute_s);
  kill(b.process().pid(), SIGCONT);
  ASSERT_TRUE(hears(events, "robot_back", "b")) << a.log();

  test::Talk talk(socket(b));
  talk.ask(R"({"class":"STATUS"})");
  EXPECT_EQ(talk.hear_class("STATUS").value("robot", ""), "b");
  EXPECT_TRUE(test::wait_until([&] { return b.status("keyframes", 0) > keyframes + 2; }, 90s)) << b.log();
  EXPECT_TRUE(test::wait_until([&] { return b.status("map_digest", map) != map; }, 90s)) << "it grows" << b.log();
  EXPECT_TRUE(agree(a, b)) << a.log() << b.log();
  EXPECT_EQ(test::text_of(b.out() / "life"), life);
  const std::string said = b.log();
  EXPECT_THAT(said, Not(HasSubstr("has not got on"))) << "no thread was stuck";
  EXPECT_THAT(said, AllOf(Not(HasSubstr("is not waited for any more")), Not(HasSubstr("fell silent"))))
      << "it was not the other that was silent";
  EXPECT_THAT(said, Not(HasSubstr("a map of its own")));
  EXPECT_EQ(a.stop(), 0);
  EXPECT_EQ(b.stop(), 0);
}

}  // namespace
}  // namespace onemap
