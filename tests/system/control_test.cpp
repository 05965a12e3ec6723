// The real daemon and clients who mean ill, or only well: whatever they do, it maps on, answers the others, and says
// what it did.
#include <arpa/inet.h>
#include <fcntl.h>
#include <gmock/gmock.h>
#include <grp.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <cmath>
#include <deque>
#include <map>
#include <set>

#include "daemon/control/control_actions.hpp"
#include "daemon/control/robot_facts.hpp"
#include "support/control_robot.hpp"
#include "support/prometheus_parser.hpp"

namespace onemap {
namespace {

using namespace std::chrono_literals;
using control::Json;
using test::ControlRobot;
using test::Talk;
using testing::HasSubstr;

double dropped(const ControlRobot& robot, const std::string& reason) {
  const auto families = test::PrometheusParser::parse(robot.metrics());
  const auto& samples = families.at("onemap_control_clients_dropped_total").samples;
  const auto found = samples.find("onemap_control_clients_dropped_total{reason=" + reason + "}");
  return found == samples.end() ? 0 : found->second;
}

int connect_tcp(std::uint16_t port) {
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0) << port;
  return fd;
}

std::string read_all(int fd) {
  std::string text;
  std::array<char, 65536> bytes{};
  for (ssize_t got = 0; (got = recv(fd, bytes.data(), bytes.size(), 0)) > 0;)
    text.append(bytes.data(), static_cast<std::size_t>(got));
  close(fd);
  return text;
}

std::string http(std::uint16_t port, const std::string& request) {
  const int fd = connect_tcp(port);
  EXPECT_EQ(send(fd, request.data(), request.size(), MSG_NOSIGNAL), static_cast<ssize_t>(request.size()));
  return read_all(fd);
}

TEST(Control, GreetsAnswersAndStreamsPosesAtFrameRate) {
  const test::TempFolder folder;
  ControlRobot robot(folder);
  Talk talk(robot.socket());
  const Json hello = talk.hear();
  EXPECT_EQ(hello.value("class", ""), "VERSION");
  EXPECT_EQ(hello.value("protocol", 0), control::kProtocolMajor);
  EXPECT_EQ(hello.value("robot", ""), "r1");
  for (const char* name : {"STATUS", "PEERS", "MAP", "POSE", "CAMERAS", "METRICS", "DOCTOR"}) {
    talk.ask(fmt::format(R"({{"class":"{}","id":"{}"}})", name, name));
    const Json answer = talk.hear();
    EXPECT_EQ(answer.value("class", ""), name);
    EXPECT_EQ(answer.value("id", ""), name);
    EXPECT_GT(answer.size(), 2u);
  }
  const auto dropped_frames = [&] { return robot.ask_once(R"({"class":"STATUS"})").value("frames_dropped", -1); };
  const int dropped_before = dropped_frames();
  talk.ask(R"({"class":"WATCH","classes":["POSE"]})");
  EXPECT_EQ(talk.hear().dump(), R"({"class":"WATCH","enable":true,"classes":["POSE"]})");
  std::vector<double> times;
  for (int i = 0; i < 10; ++i) {
    const Json pose = talk.hear();
    ASSERT_EQ(pose.value("class", ""), "POSE");
    EXPECT_EQ(pose.at("T_odom_camera").size(), 7u);
    times.push_back(pose.value("time_s", 0.0));
  }
  EXPECT_GE(dropped_before, 0);
  const bool every_frame = dropped_frames() == dropped_before;
  for (std::size_t i = 1; i < times.size(); ++i) {
    const double frames = (times[i] - times[i - 1]) * 30;
    EXPECT_GT(frames, 0.9) << "in order, and each once";
    EXPECT_NEAR(frames, std::round(frames), 0.01) << "of the camera's frames";
    if (every_frame) {
      EXPECT_NEAR(frames, 1, 0.01) << "a pose for each of them";
    }
  }
  talk.ask(R"({"class":"WATCH","enable":false})");
  EXPECT_FALSE(talk.hear_class("WATCH").value("enable", true));
  talk.ask(R"({"class":"STATUS"})");
  EXPECT_EQ(talk.hear().value("class", ""), "STATUS") << "no pose comes any more";
}

// Another program's way to the poses: a line a frame as TUM has it, which a robot's own controller reads.
TEST(Control, PoseSocketsGiveALineAFrameWhichTheControlSocketBearsOut) {
  const test::TempFolder folder;
  ControlRobot robot(folder, fmt::format("[poses]\nsocket = \"{}\"\n", folder / "poses"));
  for (const char* frame : {"odom", "map"}) {
    Talk reader((folder / "poses.") + frame);
    ASSERT_TRUE(reader.connected()) << frame;
    double before = 0;
    EXPECT_EQ(reader.hear_line(), fmt::format("# time tx ty tz qx qy qz qw: T_{}_camera", frame));
    for (int i = 0; i < 5; ++i) {
      const auto line = reader.hear_line();
      ASSERT_TRUE(line) << frame;
      std::istringstream numbers(*line);
      std::array<double, 8> pose{};
      for (double& number : pose) ASSERT_TRUE(numbers >> number) << *line;
      EXPECT_GT(pose[0], before) << "in order";
      before = pose[0];
      EXPECT_NEAR(pose[4] * pose[4] + pose[5] * pose[5] + pose[6] * pose[6] + pose[7] * pose[7], 1, 1e-6);
    }
    EXPECT_NEAR(robot.ask_once(R"({"class":"POSE"})").value("time_s", 0.0), before, 60) << "of one clock";
  }
  EXPECT_TRUE(robot.maps_on()) << "whoever has gone is waited for by nobody";
}

TEST(Control, GarbageLongLinesAndBinaryAreAnsweredAndLoseNothing) {
  const test::TempFolder folder;
  ControlRobot robot(folder);
  Talk talk = robot.talk();
  std::string binary;
  for (int i = 0; i < 3000; ++i) binary += static_cast<char>(i * 37 % 256 == '\n' ? 0 : i * 37 % 256);
  for (const std::string& line :
       {std::string("hello?"), std::string("GET / HTTP/1.1"), binary, std::string(1 << 20, '{'),
        std::string(R"({"class":"STATUS","all":1})"), std::string(R"({"class":"REBOOT"})")}) {
    ASSERT_TRUE(talk.ask(line));
    const Json answer = talk.hear();
    EXPECT_EQ(answer.value("class", ""), "ERROR") << line.substr(0, 40);
    EXPECT_NE(answer.value("message", ""), "");
    talk.ask(R"({"class":"POSE"})");
    EXPECT_EQ(talk.hear().value("class", ""), "POSE") << "after " << line.substr(0, 40);
  }
  EXPECT_TRUE(robot.maps_on());
}

TEST(Control, AClientThatNeverReadsIsDroppedAndNobodyWaits) {
  const test::TempFolder folder;
  ControlRobot robot(folder);
  Talk never = robot.talk(), reads = robot.talk();
  never.ask(R"({"class":"WATCH"})");
  for (int i = 0; i < 40; ++i) never.ask(R"({"class":"METRICS"})");  // half a megabyte and more
  reads.ask(R"({"class":"WATCH","classes":["POSE"]})");
  for (int i = 0; i < 30; ++i) ASSERT_TRUE(reads.hear().is_object());
  EXPECT_TRUE(test::wait_until([&] { return dropped(robot, "slow") + dropped(robot, "stalled") == 1; }, 90s));
  EXPECT_TRUE(robot->says("dropped, 1 so far"));
  EXPECT_EQ(reads.hear().value("class", ""), "POSE");
  EXPECT_TRUE(never.is_closed());
  EXPECT_TRUE(robot.maps_on());
}

TEST(Control, AThousandHalfOpenClientsKeepNobodyOut) {
  rlimit files{};
  getrlimit(RLIMIT_NOFILE, &files);
  files.rlim_cur = files.rlim_max;
  setrlimit(RLIMIT_NOFILE, &files);
  if (files.rlim_cur < 1100) GTEST_SKIP() << "this process may have only " << files.rlim_cur << " descriptors";
  const test::TempFolder folder;
  ControlRobot robot(folder);
  Talk worker = robot.talk();
  worker.ask(R"({"class":"STATUS"})");
  EXPECT_EQ(worker.hear().value("class", ""), "STATUS");
  const double before = robot->memory_mb("VmRSS:");
  std::deque<Talk> crowd;
  for (int i = 0; i < 1000; ++i) {
    ASSERT_TRUE(crowd.emplace_back(robot.socket()).connected()) << i << ": " << strerror(errno);
    if (i % 2 == 0) crowd.back().say("{\"class\":");
  }
  EXPECT_TRUE(robot.maps_on()) << "newcomers are answered";
  worker.ask(R"({"class":"POSE"})");
  EXPECT_EQ(worker.hear().value("class", ""), "POSE") << "and so is who was here before";
  EXPECT_GE(dropped(robot, "crowded_out"), 1000 - 64);
  const double most = std::string_view(ONEMAP_SANITIZE).empty() ? before + 60 : before + 600;
  EXPECT_LT(robot->memory_mb("VmRSS:"), most) << "memory is bounded";
}

TEST(Control, OutOfDescriptorsItMapsOnAndServesAgainWhenThereAreSome) {
  const test::TempFolder folder;
  ControlRobot robot(folder);
  Talk worker = robot.talk();
  const auto used = [&](std::size_t number) {
    return std::filesystem::exists(std::filesystem::symlink_status(fmt::format("/proc/{}/fd/{}", robot.pid(), number)));
  };
  std::size_t free = 0;
  while (used(free)) ++free;
  rlimit old{}, few{};
  ASSERT_EQ(prlimit(robot.pid(), RLIMIT_NOFILE, nullptr, &old), 0);
  few = {free, old.rlim_max};
  ASSERT_EQ(prlimit(robot.pid(), RLIMIT_NOFILE, &few, nullptr), 0);
  std::deque<Talk> more;
  for (int i = 0; i < 20; ++i) more.emplace_back(robot.socket());
  EXPECT_TRUE(robot->says("no descriptor is left for another client", 60s)) << robot->log();
  const auto frames = [&] {
    worker.ask(R"({"class":"STATUS"})");
    return worker.hear().value("frames", 0);
  };
  const int before = frames();
  EXPECT_TRUE(test::wait_until([&] { return frames() > before + 5; }, 60s));
  ASSERT_EQ(prlimit(robot.pid(), RLIMIT_NOFILE, &old, nullptr), 0);
  more.clear();
  EXPECT_TRUE(
      test::wait_until([&] { return robot.ask_once(R"({"class":"POSE"})").value("class", "") == "POSE"; }, 30s));
  EXPECT_GE(dropped(robot, "no_descriptors"), 1);
  EXPECT_EQ(robot->stop(), 0) << robot->log();
}

TEST(Control, AStoppedDaemonGoesOnWhereItWas) {
  const test::TempFolder folder;
  ControlRobot robot(folder);
  Talk watches = robot.talk(), asks = robot.talk();
  watches.ask(R"({"class":"WATCH","classes":["POSE"]})");
  EXPECT_EQ(watches.hear().value("class", ""), "WATCH");
  kill(robot.pid(), SIGSTOP);
  asks.ask(R"({"class":"STATUS"})");
  EXPECT_FALSE(asks.hear(3s / test::kPatience).is_object()) << "it is stopped";
  kill(robot.pid(), SIGCONT);
  EXPECT_EQ(asks.hear().value("class", ""), "STATUS");
  for (int i = 0; i < 10; ++i) EXPECT_EQ(watches.hear().value("class", ""), "POSE");
  EXPECT_TRUE(robot.maps_on());
  EXPECT_EQ(robot->stop(), 0);
}

// A request of each class that changes something, which would do so for nothing or fail.
const std::map<std::string, std::string> kChanges{
    {"SNAPSHOT", R"({"class":"SNAPSHOT","kinds":["none"]})"}, {"SAVE", R"({"class":"SAVE","path":"/nonexistent/map"})"},
    {"LOAD", R"({"class":"LOAD","path":"/none"})"},           {"RECORD", R"({"class":"RECORD","enable":false})"},
    {"UNMERGE", R"({"class":"UNMERGE","a":"x","b":"y"})"},    {"MERGE", R"({"class":"MERGE","a":"x","b":"y"})"}};

TEST(Control, WhatChangesSomethingIsKnownToTheseTests) {
  std::set<std::string> changing, known;
  for (const auto& command : daemon::control_commands([] { return daemon::RobotFacts{}; }, {}))
    if (command.effect == daemon::Effect::changes) changing.emplace(command.name);
  for (const auto& [name, request] : kChanges) known.insert(name);
  EXPECT_EQ(known, changing);
}

bool is_denied(Talk& talk, const std::string& request) {
  talk.ask(request);
  const Json answer = talk.hear();
  const std::string what = answer.is_object() ? answer.value("message", "") : "";
  // What takes long is said to be under way first, and its end comes unasked.
  if (answer.is_object() && answer.value("class", "") == "ACK") talk.hear();
  return what.find("changes something: only root") != std::string::npos;
}

constexpr int kNoAnswer = 100, kNobodyElse = 101;

// Of how many changes a client of another user and group hears that they are not for it.
int denied_as(const ControlRobot& robot, uid_t user, gid_t group) {
  const pid_t child = fork();
  if (child == 0) {
    if (setgroups(0, nullptr) != 0 || setresgid(group, group, group) != 0 || setresuid(user, user, user) != 0)
      _exit(kNobodyElse);
    Talk talk(robot.socket());
    if (!talk.hear().is_object() || !talk.ask(R"({"class":"STATUS"})") || talk.hear().value("class", "") != "STATUS")
      _exit(kNoAnswer);
    int denied = 0;
    for (const auto& [name, request] : kChanges) denied += is_denied(talk, request) ? 1 : 0;
    _exit(denied);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WEXITSTATUS(status);
}

TEST(Control, OthersMayReadAndOnlyTheSocketsGroupMayChange) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can be somebody else";
  constexpr uid_t kNobody = 65534;
  constexpr gid_t kGroup = 4242;
  const test::TempFolder folder;
  ASSERT_EQ(chown(folder.path().c_str(), static_cast<uid_t>(-1), kGroup), 0);
  ASSERT_EQ(chmod(folder.path().c_str(), 02755), 0);  // what is made in it gets its group
  ControlRobot robot(folder);
  EXPECT_EQ(denied_as(robot, kNobody, kNobody), static_cast<int>(kChanges.size()));
  EXPECT_EQ(denied_as(robot, kNobody, kGroup), 0);
  EXPECT_EQ(denied_as(robot, 0, 0), 0);
  EXPECT_TRUE(robot.maps_on());
}

TEST(Control, TcpReadsAndChangesNothing) {
  const test::TempFolder folder;
  ControlRobot robot(folder);
  Talk talk(connect_tcp(robot.port_after("read-only, at ")));
  EXPECT_EQ(talk.hear().value("class", ""), "VERSION");
  talk.ask(R"({"class":"STATUS"})");
  EXPECT_EQ(talk.hear().value("robot", ""), "r1");
  for (const auto& [name, request] : kChanges) EXPECT_TRUE(is_denied(talk, request)) << name;
}

TEST(Control, MetricsComeOverHttpAndNothingElseDoes) {
  const test::TempFolder folder;
  ControlRobot robot(folder);
  const auto port = robot.port_after("metrics at http://");
  const std::string good = http(port, "GET /metrics HTTP/1.1\r\nHost: x\r\n\r\n");
  EXPECT_THAT(good, testing::StartsWith("HTTP/1.1 200 OK\r\nContent-Type: text/plain; version=0.0.4"));
  const auto families = test::PrometheusParser::parse(good.substr(good.find("\r\n\r\n") + 4));
  EXPECT_GT(families.at("onemap_frame_milliseconds").samples.at("onemap_frame_milliseconds_count{step=all}"), 0);
  EXPECT_EQ(families.at("onemap_info").samples.size(), 1u);
  const auto over_socket = test::PrometheusParser::parse(robot.metrics());
  EXPECT_EQ(over_socket.size(), families.size()) << "the same families either way";
  const std::pair<std::string, std::string> wrong[] = {
      {"POST /metrics HTTP/1.1\r\n\r\n", "405"}, {"GET / HTTP/1.1\r\n\r\n", "404"},
      {"GET /metricsx HTTP/1.0\r\n\r\n", "404"}, {"hello\r\n\r\n", "400"},
      {std::string("\0\xff\r\n\r\n", 6), "400"}, {"GET /" + std::string(4096, 'x'), "400"}};
  for (const auto& [request, status] : wrong)
    EXPECT_THAT(http(port, request), testing::StartsWith("HTTP/1.1 " + status)) << request.substr(0, 20);
  std::deque<Talk> slow;
  for (int i = 0; i < 40; ++i) slow.emplace_back(connect_tcp(port)).say("GET /met");
  EXPECT_TRUE(robot.maps_on());
  EXPECT_TRUE(slow.front().is_closed()) << "nobody holds a place for long";
  EXPECT_TRUE(
      test::wait_until([&] { return http(port, "GET /metrics HTTP/1.1\r\n\r\n").starts_with("HTTP/1.1 200"); }, 30s));
}

TEST(Control, StopsWithClientsThereAndTakesALeftOverSocket) {
  const test::TempFolder folder;
  {
    ControlRobot robot(folder);
    Talk talk = robot.talk();
    talk.ask(R"({"class":"WATCH"})");
    EXPECT_EQ(robot->stop(), 0) << robot->log();
    EXPECT_TRUE(talk.is_closed());
    EXPECT_FALSE(std::filesystem::exists(robot.socket()));
  }
  {
    ControlRobot robot(folder);
    robot->process().kill();
    EXPECT_TRUE(std::filesystem::exists(robot.socket())) << "left over";
  }
  ControlRobot robot(folder);
  EXPECT_TRUE(robot.maps_on());
  const int second = test::run(
      "onemapd", {"--camera", ControlRobot::kCamera, "--out", folder / "other", "--config", folder / "control.toml"},
      folder / "second.txt");
  EXPECT_EQ(second, 1);
  EXPECT_THAT(test::text_of(folder / "second.txt"),
              HasSubstr("control.socket: " + robot.socket() + ": is in use by another daemon"));
}

}  // namespace
}  // namespace onemap
