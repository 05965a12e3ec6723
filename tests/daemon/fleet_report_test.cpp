#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "daemon/fleet/fleet.hpp"
#include "daemon/fleet/log_tail.hpp"
#include "temp_folder.hpp"

namespace onemap::daemon {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

Report report_of(const std::string& name, std::uint64_t digest) {
  Report report{true, "robot1", 100, 50, {}};
  RobotReport robot;
  robot.name = name;
  robot.map_digest = digest;
  report.robots.push_back(robot);
  return report;
}

TEST(FleetReport, ARobotThatFailedLeavesNoOneMapAndIsMarked) {
  Report dead = report_of("robot1", 7);
  dead.reference.clear();
  dead.global_points = 0;
  dead.robots[0].failed = "ended too early with signal 9";
  const Report team = join_reports({dead, report_of("robot2", 7), report_of("robot3", 7)}, true);
  EXPECT_FALSE(team.same_map);
  EXPECT_EQ(team.reference, "robot1") << "as the living know it";
  EXPECT_EQ(team.global_points, 50u);
  EXPECT_THAT(to_table(team), HasSubstr("robot1: FAILED: ended too early with signal 9"));
  const auto json = nlohmann::json::parse(to_json(team));
  EXPECT_EQ(json["robots"][0]["failed"], "ended too early with signal 9");
  EXPECT_FALSE(json["robots"][1].contains("failed"));
  EXPECT_EQ(to_json(*report_from_json(to_json(team), "")), to_json(team));
}

TEST(FleetReport, AFailureAloneIsEnoughForNoOneMap) {
  Report failed = report_of("robot2", 7);
  failed.robots[0].failed = "exit status 1";
  EXPECT_TRUE(join_reports({report_of("robot1", 7), report_of("robot2", 7)}, true).same_map);
  EXPECT_FALSE(join_reports({report_of("robot1", 7), failed}, true).same_map);
}

TEST(FleetReport, WhatWasRefusedStandsBelowTheTable) {
  Report report = report_of("robot1", 7);
  EXPECT_THAT(to_table(report), Not(HasSubstr("robot1:")));
  report.robots[0].blocks_refused = 812;
  report.robots[0].plan_votes_refused = 9;
  report.robots[0].refused = {{"bad_frame", 3}, {"id_\x1b[31mconflict", 1}};
  EXPECT_THAT(to_table(report),
              AllOf(HasSubstr("robot1: no room for 812 blocks of the local map"),
                    HasSubstr("robot1: no room for all of the floor plan's free space: raise map.plan_budget_mb"),
                    HasSubstr("robot1: refused from the network: bad_frame 3, id_\\x1b[31mconflict 1")));
}

Merge merge_of(const std::string& a, const std::string& b, const std::string& refused = "") {
  return {a, b, refused, 12, 40, 18, 812, 0.345, 12.34, 1.25, 34.1};
}

// The paper's figure 9: which clouds joined two robots' maps, how many agree, where the one's reference is in the
// other.
TEST(FleetReport, TellsOfEachPairWhatJoinedItOrWhyNot) {
  Report first = report_of("robot1", 7);
  first.merges = {merge_of("robot1", "robot2"), merge_of("robot1", "robot3", "too few matches")};
  const Report team = join_reports({first, report_of("robot2", 7)}, true);
  EXPECT_EQ(to_table(team.merges),
            "merge           cloud r  cloud s  pairs  inliers  ratio  error mm  distance m  turn deg\n"
            "robot1  robot2       12       40     18      812   0.34      12.3        1.25      34.1\n"
            "robot1 and robot3 are not joined: too few matches\n");
  EXPECT_THAT(to_text(team, "out"), HasSubstr("\n\n" + to_table(team.merges) + "\nmaps equal"));
  const auto json = nlohmann::json::parse(to_json(team));
  EXPECT_EQ(json["merges"][0]["inliers"], 812);
  EXPECT_EQ(json["merges"][0]["joined"], true);
  EXPECT_EQ(json["merges"][1]["refused"], "too few matches");
  EXPECT_EQ(to_json(*report_from_json(to_json(team), "")), to_json(team));
  EXPECT_EQ(to_table(std::vector<Merge>{}), "");
}

TEST(FleetReport, OfManyRefusedPairsTenAreNamed) {
  std::vector<Merge> merges(13, merge_of("robot1", "robot2", "too few matches"));
  const std::string table = to_table(merges);
  EXPECT_EQ(std::ranges::count(table, '\n'), 11);
  EXPECT_THAT(table, HasSubstr("and 3 more pairs"));
}

TEST(FleetReport, ForeignTextInItIsText) {
  Report report = report_of("robot1", 7);
  report.robots[0].camera = "replay:\xff\n";
  report.robots[0].failed = "\xfe";
  const auto json = nlohmann::json::parse(to_json(report));
  EXPECT_EQ(json["robots"][0]["camera"], "replay:\\xff\\x0a");
  EXPECT_EQ(json["robots"][0]["failed"], "\\xfe");
}

TEST(FleetText, ListsTheFilesThatAreThere) {
  const test::TempFolder out;
  out.write("robot1/local.png", "x");
  out.write("robot2/global.ply", "x");
  const Report team = join_reports({report_of("robot1", 7), report_of("robot2", 7)}, true);
  const std::string text = to_text(team, out.path().string()), folder = "  " + out.path().string();
  EXPECT_THAT(text, AllOf(HasSubstr("pictures:\n" + folder + "/robot1/local.png\nmodels"),
                          HasSubstr("PCD):\n" + folder + "/robot2/global.ply\nreport: ")));
  EXPECT_THAT(text, AllOf(HasSubstr("maps equal: yes; reference robot1; merged in 100 ms; 50 points"),
                          Not(HasSubstr("global.png")), Not(HasSubstr("glb"))));
  EXPECT_THAT(to_text(team, out.path().string() + "/none"),
              AllOf(Not(HasSubstr("pictures")), Not(HasSubstr("models"))));
}

TEST(FleetText, NoLineIsWiderThanATerminal) {
  const test::TempFolder out;
  for (const char* map : {"local", "global"})
    for (const char* kind : {".png", ".glb", ".ply", ".pcd"}) out.write("robot1/" + std::string(map) + kind, "x");
  Report team = join_reports({report_of("robot1", 7)}, true);
  team.merges = {merge_of("robot10", "robot11")};
  std::istringstream text(to_text(team, out.path().string()));
  int models = 0;
  for (std::string line; std::getline(text, line);) {
    EXPECT_LE(line.size(), Progress::kColumns) << line;
    for (std::size_t at = 0; (at = line.find("robot1/", at)) != std::string::npos; ++at) ++models;
  }
  EXPECT_EQ(models, 8);
}

TEST(FleetProgress, ShowsTheKeyframesThatThereAre) {
  DaemonStatus status;
  status.frames = 50;
  status.frames_expected = 100;
  status.keyframes = 4;
  EXPECT_THAT(Progress::line("robot1", status), HasSubstr("4 keyframes"));
  testing::internal::CaptureStderr();
  Progress({"robot1"}, false, Instant{}).show({status}, Instant{});
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "robot1 tracking 50 % (4 keyframes)\n");
}

TEST(LogTail, IsTheLastLinesAsText) {
  const test::TempFolder folder;
  folder.write("log.txt", "one\ntwo\nth\xffree\n");
  EXPECT_THAT(last_lines(folder / "log.txt", 2), ElementsAre("two", "th\\xffree"));
  EXPECT_THAT(last_lines(folder / "log.txt", 9), ElementsAre("one", "two", "th\\xffree"));
  folder.write("log.txt", "cut");
  EXPECT_THAT(last_lines(folder / "log.txt", 2), ElementsAre("cut"));
  folder.write("log.txt", std::string(100000, 'x') + "\n" + std::string(5000, 'y') + "\nlast\n");
  EXPECT_THAT(last_lines(folder / "log.txt", 5), ElementsAre(std::string(5000, 'y'), "last"));
  folder.write("log.txt", "");
  EXPECT_THAT(last_lines(folder / "log.txt", 2), IsEmpty());
  EXPECT_THAT(last_lines(folder / "none.txt", 2), IsEmpty());
}

}  // namespace
}  // namespace onemap::daemon
