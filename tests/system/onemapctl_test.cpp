// onemapctl and the example client against a real daemon, and against none.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "support/control_robot.hpp"
#include "support/prometheus_parser.hpp"

namespace onemap {
namespace {

using test::ControlRobot;
using test::TempFolder;
using testing::AllOf;
using testing::HasSubstr;

struct Said {
  int status;
  std::string text;
};

Said ctl(const TempFolder& folder, std::vector<std::string> arguments) {
  const int status = test::run("onemapctl", arguments, folder / "ctl.txt");
  return {status, test::text_of(folder / "ctl.txt")};
}

TEST(Onemapctl, ShowsPeopleAndProgramsWhatTheDaemonKnows) {
  const TempFolder folder;
  ControlRobot robot(folder);
  const std::pair<const char*, const char*> commands[] = {{"status", "robot         r1"},
                                                          {"peers", "this robot is alone"},
                                                          {"map", "digest"},
                                                          {"pose", "tracked"},
                                                          {"cameras", "\non this machine:\n"},
                                                          {"doctor", "ok   camera"},
                                                          {"consensus", "nobody to agree"},
                                                          {"metrics", "onemap_frames"}};
  for (const auto& [command, words] : commands) {
    const Said people = ctl(folder, {"--socket", robot.socket(), command});
    EXPECT_EQ(people.status, 0) << command << people.text;
    EXPECT_THAT(people.text, HasSubstr(words)) << command;
    const Said programs = ctl(folder, {command, "--json", "--socket", robot.socket()});
    EXPECT_EQ(programs.status, 0);
    const auto object = control::Json::parse(programs.text, nullptr, false);
    std::string name = command;
    std::ranges::transform(name, name.begin(), [](char c) { return static_cast<char>(std::toupper(c)); });
    EXPECT_EQ(object.value("class", ""), name) << programs.text;
  }
  const Said metrics = ctl(folder, {"--socket", robot.socket(), "metrics"});
  EXPECT_EQ(metrics.status, 0);
  EXPECT_NO_THROW(test::PrometheusParser::parse(metrics.text));
}

TEST(Onemapctl, TheTeamsKeyIsSaidToProgramsAndItselfOnlyWhenAskedFor) {
  const TempFolder folder;
  const std::string file = folder / "team.key";
  const auto team = [&](std::vector<std::string> words) {
    words.insert(words.end(), {"--file", file, "--json"});
    words.insert(words.begin(), "team");
    const Said said = ctl(folder, words);
    EXPECT_EQ(said.status, 0) << said.text;
    return control::Json::parse(said.text, nullptr, false);
  };
  const auto made = team({"init"});
  EXPECT_EQ(made.value("class", ""), "TEAM");
  EXPECT_EQ(made.value("file", ""), file);
  EXPECT_EQ(team({"show"}), made) << "no key in either";
  const std::string key = team({"show", "--secret"}).value("key", "");
  EXPECT_EQ(key + "\n", test::text_of(file));
  std::filesystem::remove(file);
  EXPECT_EQ(team({"join", key}), made) << "the same team";
}

TEST(Onemapctl, FollowsUntilTheDaemonEnds) {
  const TempFolder folder;
  ControlRobot robot(folder);
  auto follow = test::start("onemapctl", {"--socket", robot.socket(), "pose", "--follow"}, folder / "poses.txt");
  auto watch = test::start("onemapctl", {"--socket", robot.socket(), "watch", "POSE", "STATUS", "PEERS", "--json"},
                           folder / "watch.txt");
  const auto watched = [&](const char* name) {
    return test::text_of(folder / "watch.txt").find(fmt::format("\"class\":\"{}\"", name)) != std::string::npos;
  };
  const auto all = [&] {
    return test::lines(folder / "poses.txt") > 5 && watched("POSE") && watched("STATUS") && watched("PEERS");
  };
  EXPECT_TRUE(test::wait_until(all, std::chrono::seconds(60)));
  EXPECT_EQ(robot->stop(), 0);
  EXPECT_TRUE(follow.wait(test::kPatience * std::chrono::seconds(30)));
  EXPECT_TRUE(watch.wait(test::kPatience * std::chrono::seconds(30)));
  EXPECT_EQ(follow.exit_code(), 3) << test::text_of(folder / "poses.txt");
}

TEST(Onemapctl, WithoutADaemonItSaysWhereItLookedAndWhatToDo) {
  const TempFolder folder;
  folder.write("file", "no socket");
  const Said nothing = ctl(folder, {"--socket", folder / "none.sock", "status"});
  EXPECT_EQ(nothing.status, 3);
  EXPECT_THAT(nothing.text, AllOf(HasSubstr(folder / "none.sock: there is nothing"), HasSubstr("is onemapd running")));
  EXPECT_THAT(ctl(folder, {"--socket", folder / "file", "status"}).text, HasSubstr("nobody listens"));
  {
    ControlRobot robot(folder);
    kill(robot.pid(), SIGSTOP);
    const Said stopped = ctl(folder, {"--socket", robot.socket(), "--timeout", "0.5", "status"});
    kill(robot.pid(), SIGCONT);
    EXPECT_EQ(stopped.status, 3);
    EXPECT_THAT(stopped.text, HasSubstr("does not answer"));
    robot->process().kill();
  }
  const Said left_over = ctl(folder, {"--socket", folder / "c.sock", "doctor"});
  EXPECT_EQ(left_over.status, 3);
  EXPECT_THAT(left_over.text, AllOf(HasSubstr("BAD  daemon"), HasSubstr("nobody listens"),
                                    HasSubstr("-> systemctl start onemapd"), HasSubstr("ok   config")));
}

TEST(Onemapctl, WrongCommandLinesEndWithTwoAndHelpIsThere) {
  const TempFolder folder;
  for (const std::vector<std::string>& wrong : std::vector<std::vector<std::string>>{
           {}, {"stats"}, {"status", "--jsn"}, {"why", "a"}, {"record"}, {"load"}, {"status", "--timeout", "never"}}) {
    const Said said = ctl(folder, wrong);
    EXPECT_EQ(said.status, 2) << said.text;
    EXPECT_THAT(said.text, AllOf(testing::StartsWith("onemapctl: "), HasSubstr("--help says what there is")));
  }
  const Said help = ctl(folder, {"--help"});
  EXPECT_EQ(help.status, 0);
  EXPECT_THAT(help.text, AllOf(HasSubstr("Examples:"), HasSubstr("Exit status:")));
  EXPECT_THAT(ctl(folder, {"pose", "--help"}).text, HasSubstr("--follow"));
  EXPECT_THAT(ctl(folder, {"--version"}).text, testing::MatchesRegex("onemapctl [0-9]+\\.[0-9]+\\.[0-9]+\n"));
}

TEST(Onemapctl, WhatTheDaemonRefusesEndsWithOne) {
  const TempFolder folder;
  ControlRobot robot(folder);
  const Said refused = ctl(folder, {"--socket", robot.socket(), "watch", "WEATHER"});
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.text, HasSubstr("classes: expected a list of POSE, EVENT, PEERS, STATUS"));
}

// Two robots in one room, asked over their sockets.
TEST(Onemapctl, SaysWhyTwoRobotsAreJoinedTakesThatBackAndLetsItCountAgain) {
  using test::Robot;
  const TempFolder folder;
  const auto pa = test::free_port(), pb = test::free_port();
  const auto start = [&](const std::string& name, int number, std::uint16_t own, std::uint16_t other) {
    folder.write(name + ".toml", fmt::format("[run]\nmerge_while_mapping_s = 1\n[control]\nsocket = \"{}\"\n",
                                             folder / (name + ".sock")));
    return Robot(folder, name,
                 fmt::format("simulated:living-room?width=320&height=240&robot={}&robots=3&frames=60&seed=3", number),
                 {"--config", folder / (name + ".toml"), "--speed", "max", "--listen", fmt::format("127.0.0.1:{}", own),
                  "--peer", fmt::format("127.0.0.1:{}", other)});
  };
  Robot a = start("a", 1, pa, pb), b = start("b", 2, pb, pa);
  const auto together = [&](std::size_t robots) {
    const auto holds = [&](Robot& robot) {
      return robot.status("agreed", false) && robot.status("robots_in_map", std::size_t{0}) == robots;
    };
    return test::wait_until([&] { return holds(a) && holds(b); }, std::chrono::seconds(120));
  };
  ASSERT_TRUE(together(2)) << a.log() << b.log();
  const Said why = ctl(folder, {"--socket", folder / "a.sock", "why", "a", "b"});
  EXPECT_EQ(why.status, 0) << why.text;
  EXPECT_THAT(why.text, AllOf(HasSubstr("they are in one map"), HasSubstr("accepted"), HasSubstr("in use")));
  const auto json_of = [&](const std::string& robot, const std::string& command) {
    const Said said = ctl(folder, {"--socket", folder / (robot + ".sock"), "--json", command, "a", "b"});
    EXPECT_EQ(said.status, 0) << said.text;
    return control::Json::parse(said.text, nullptr, false);
  };
  const auto why_json = json_of("a", "why");
  EXPECT_EQ(why_json.value("of", ""), "WHY");
  EXPECT_TRUE(why_json.value("one_map", false)) << why_json.dump();
  const Said nobody = ctl(folder, {"--socket", folder / "a.sock", "why", "a", "nobody"});
  EXPECT_EQ(nobody.status, 1);
  EXPECT_THAT(nobody.text, HasSubstr("nobody"));
  const auto apart = json_of("b", "unmerge");
  EXPECT_EQ(apart.value("of", ""), "UNMERGE");
  EXPECT_GT(apart.value("pairs", 0), 0) << apart.dump();
  ASSERT_TRUE(together(1)) << a.log() << b.log();
  const Said ruled = ctl(folder, {"--socket", folder / "a.sock", "why", "a", "b"});
  EXPECT_THAT(ruled.text, AllOf(HasSubstr("they are not in one map"), HasSubstr("they are apart, at b")));
  EXPECT_EQ(json_of("a", "merge").value("of", ""), "MERGE");
  ASSERT_TRUE(together(2)) << a.log() << b.log();
}

// What takes long is acknowledged, done by other threads, and answered for.
TEST(Onemapctl, DrawsSavesAndRecordsWhileTheRobotWorks) {
  const TempFolder folder;
  ControlRobot robot(folder);
  const auto done = [&](const std::vector<std::string>& words) {
    std::vector<std::string> arguments{"--socket", robot.socket(), "--json", "--timeout", "200"};
    arguments.insert(arguments.end(), words.begin(), words.end());
    const Said said = ctl(folder, arguments);
    EXPECT_EQ(said.status, 0) << said.text;
    return control::Json::parse(said.text, nullptr, false);
  };
  const auto begun = done({"record", "start"});
  EXPECT_TRUE(begun.value("recording", false));
  const std::string recording = begun.value("folder", "");
  EXPECT_TRUE(robot.maps_on());
  const auto ended = done({"record", "stop"});
  EXPECT_FALSE(ended.value("recording", true));
  EXPECT_GT(ended.value("frames", 0), 0);
  EXPECT_GT(test::lines(recording + "/rgb.txt"), 0u);

  const auto saved = done({"save", "kept.omap"});
  EXPECT_EQ(std::filesystem::file_size(robot->out() / "kept.omap"), saved.value("bytes", 0u));
  EXPECT_EQ(done({"load", "kept.omap"}).value("robots", control::Json()).at(0), "r1");

  const auto drawn = done({"snapshot", "--view", "top", "--kind", "png"});
  EXPECT_TRUE(std::filesystem::exists(drawn.value("folder", "") + "/local_top.png")) << drawn.dump();

  ASSERT_EQ(mkfifo((robot->out() / "pipe").c_str(), 0600), 0);  // nobody ever writes into it
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"save", "../x"},
                                             {"save", "/etc/x"},
                                             {"load", "none.omap"},
                                             {"load", "pipe"},
                                             {"load", "none.log"},
                                             {"load", "recordings"},
                                             {"load", "../x.log"},
                                             {"save", "../x.log"},
                                             {"snapshot", "--view", "moon"},
                                             {"record", "start", "a/../../b"}}) {
    std::vector<std::string> arguments{"--socket", robot.socket()};
    arguments.insert(arguments.end(), words.begin(), words.end());
    const Said said = ctl(folder, arguments);
    EXPECT_EQ(said.status, 1) << said.text;
    EXPECT_THAT(said.text, testing::StartsWith("onemapctl: "));
  }
  EXPECT_TRUE(robot.maps_on());
}

TEST(ExampleClient, TalksToADaemonInPython) {
  if (std::system("python3 -c 'import json, socket' 2> /dev/null") != 0) GTEST_SKIP() << "there is no python3";
  const TempFolder folder;
  ControlRobot robot(folder);
  const std::string command = fmt::format("python3 {}/examples/onemap_client.py {} > {} 2>&1", ONEMAP_SOURCE_DIR,
                                          robot.socket(), folder / "py.txt");
  const int status = std::system(command.c_str());
  const std::string said = test::text_of(folder / "py.txt");
  EXPECT_EQ(WEXITSTATUS(status), 0) << said;
  EXPECT_EQ(test::lines(folder / "py.txt"), 11u) << said;
  EXPECT_THAT(said, testing::StartsWith("r1: tracking, "));
}

}  // namespace
}  // namespace onemap
