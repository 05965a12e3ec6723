#include "daemon/team_words.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace onemap::daemon {
namespace {

using testing::HasSubstr;

std::string said(const mapping::TeamEvent& event) {
  Log log("robot1");
  testing::internal::CaptureStderr();
  say(event, log);
  return testing::internal::GetCapturedStderr();
}

const RobotId kA = RobotId::from_name("a"), kB = RobotId::from_name("b");

TEST(TeamWords, EveryEventIsALine) {
  EXPECT_EQ(said(mapping::RobotJoined{kA, "cam"}), "robot1: robot a joined with cam\n");
  EXPECT_THAT(said(mapping::RobotJoined{kA, "x\nrobot1: forged"}), Not(HasSubstr("\nrobot1: forged")));
  EXPECT_EQ(said(mapping::RobotFinished{kA, {9, 8, 7, 6}}),
            "robot1: robot a finished: 9 frames, 8 tracked, 7 keyframes, 6 submaps\n");
  EXPECT_EQ(said(mapping::RobotGone{kA, std::chrono::seconds(61)}),
            "robot1: robot a is not waited for any more: silent for 61 s; its records stay, and it is welcome back\n");
  EXPECT_EQ(said(mapping::RobotBack{kA}), "robot1: robot a is back\n");
  EXPECT_EQ(said(mapping::RecordRefused{{{kA, 3, 1}, 17}, 4, "submap record, voxel_um: cut short"}),
            "robot1: record 17 of a refused: submap record, voxel_um: cut short\n");
  EXPECT_THAT(said(mapping::DeciderPassedOver{kA, true}), HasSubstr("that the links refute"));
  EXPECT_THAT(said(mapping::DeciderPassedOver{kA, false}), HasSubstr("should have published"));
}

TEST(TeamWords, LinksSayWhyAndByWhom) {
  mapping::LinkRecord link;
  link.a = kA;
  link.b = kB;
  link.supporting_pairs = 3;
  link.inliers = 120;
  link.ratio_e4 = 2500;
  link.error_um = 4200;
  EXPECT_EQ(said(mapping::LinkLooked{{kA, 1}, link}),
            "robot1: link a - b accepted: 3 pairs of clouds agree, 120 inliers, ratio 0.25, error 4.2 mm\n");
  link.reason = mapping::LinkReason::icp_failed;
  link.measured = 31'400;
  EXPECT_EQ(said(mapping::LinkLooked{{kB, 1}, link}),
            "robot1: link a - b refused: the clouds do not fit (error 31.4 mm), 3 pairs of clouds agree, 120 inliers "
            "(looked at by b)\n");
  EXPECT_EQ(said(mapping::LinkLooked{{kA, 1}, link, true}), "") << "as it was";
  link.reason = mapping::LinkReason::accepted;
  link.b = kA;
  link.incarnation_other = 1;
  EXPECT_THAT(said(mapping::LinkLooked{{kA, 2}, link}), HasSubstr("link a's earlier life - a accepted: 3 pairs"));
  link.pairs = {{1, 30, 60, {}}};
  EXPECT_EQ(said(mapping::LinkLooked{{kA, 1}, link}),
            "robot1: robot a knows 1 pairs of its keyframes as one place each\n");
}

TEST(TeamWords, AnEarlierLifeHasItsNumber) {
  mapping::TeamLog log(kA, 17);
  EXPECT_EQ(chain_name(log, {kA, 17}), "a");
  EXPECT_EQ(chain_name(log, {kA, 16}), "a.16");
}

TEST(TeamWords, WhoTakesALinkBackIsNamed) {
  EXPECT_EQ(said(mapping::PairRuled{kB, {{kA, 1}, {kB, 1}, true, 1}}),
            "robot1: links a - b do not count any more, a person says at b\n");
  EXPECT_EQ(said(mapping::PairRuled{kA, {{kB, 1}, {kB, 1}, false, 2}}),
            "robot1: own loops of b count again, a person says at a\n");
}

TEST(TeamWords, AMapSaysWhatItIsMadeOfAndWhatItLacks) {
  mapping::SolutionRecord solution = mapping::alone_on_map({kA, 1});
  solution.robots.push_back({{kB, 1}, {}});
  solution.links_used = 7, solution.links_refused = 2;
  mapping::MapFused fused{true, 0xabc, solution, 12, 0, 900, 0};
  EXPECT_EQ(said(fused),
            "robot1: global map 0000000000000abc: reference a, 7 links used and 2 refused, robots a b, 12 submaps, 900 "
            "blocks, 0 refused\n");
  fused.final = false;
  fused.blocks_refused = 5;
  fused.submaps_left_out = 2;
  const std::string full = said(fused);
  EXPECT_THAT(full, HasSubstr("interim map"));
  EXPECT_THAT(full, HasSubstr("the global map is full: 5 times a block found no room; raise map.global_budget_mb"));
  EXPECT_THAT(full, HasSubstr("2 submaps are left out"));
  EXPECT_EQ(said(mapping::MapSettled{0xabc, 900, 0}), "");
  EXPECT_THAT(said(mapping::MapSettled{0xabc, 0, 7}),
              HasSubstr("is EMPTY: no submap of a robot in it could be used (7 refused)"));
}

}  // namespace
}  // namespace onemap::daemon
