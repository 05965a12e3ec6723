#include "daemon/fleet/fleet_options.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace onemap::daemon {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(FleetOptions, NamesRobotsInTheOrderGiven) {
  const auto parsed = parse_fleet_options({"--robot", "replay:a", "--robot", "replay:b:0:10", "--graph", "line",
                                           "--loss", "10%", "--delay", "2.5", "--out", "o"});
  ASSERT_TRUE(parsed.value) << parsed.text;
  EXPECT_THAT(parsed.value->cameras, ElementsAre("replay:a", "replay:b:0:10"));
  EXPECT_THAT(parsed.value->links, ElementsAre(FleetLink{0, 1}));
  EXPECT_DOUBLE_EQ(parsed.value->faults.loss, 0.1);
  EXPECT_EQ(parsed.value->faults.delay, std::chrono::microseconds(2500));
  EXPECT_EQ(fleet_robot_name(0), "robot1");
}

TEST(FleetOptions, SimulateMakesOneAddressARobot) {
  const auto parsed = parse_fleet_options({"--simulate", "2", "--frames", "40", "--seed", "9", "--out", "o"});
  ASSERT_TRUE(parsed.value) << parsed.text;
  EXPECT_THAT(parsed.value->cameras, ElementsAre("simulated:living-room?robot=1&robots=2&frames=40&seed=9",
                                                 "simulated:living-room?robot=2&robots=2&frames=40&seed=9"));
}

TEST(FleetOptions, Loss) {
  EXPECT_DOUBLE_EQ(parse_loss("0.25").value(), 0.25);
  EXPECT_DOUBLE_EQ(parse_loss("20%").value(), 0.2);
  EXPECT_DOUBLE_EQ(parse_loss("0").value(), 0);
  for (const char* wrong : {"", "1", "100%", "-0.1", "10 %", "x", "0.1x", "nan", "%"})
    EXPECT_FALSE(parse_loss(wrong).ok()) << wrong;
}

TEST(FleetOptions, RefusesWithUsage) {
  const std::vector<std::vector<std::string>> wrong{
      {"--out", "o"},                                            // no robots
      {"--simulate", "2"},                                       // nowhere to write
      {"--simulate", "2", "--robot", "replay:a", "--out", "o"},  // both
      {"--simulate", "2", "--graph", "1-3", "--out", "o"},       // no such robot
      {"--simulate", "2", "--loss", "2", "--out", "o"},          //
      {"--simulate", "2", "--speed", "slow", "--out", "o"},      //
      {"--simulate", "2", "--delay", "nan", "--out", "o"},       // no number
      {"--simulate", "2", "--delay", "-1", "--out", "o"},        //
      {"--simulate", "2", "--delay", "1e9", "--out", "o"},       //
      {"--simulate", "2", "--timeout", "nan", "--out", "o"},     //
      {"--simulate", "2", "--timeout", "inf", "--out", "o"},     //
      {"--simulate", "2", "--seed", "-1", "--out", "o"},         //
      {"--simulate", "2", "--frames", "nan", "--out", "o"},      //
      {"--simulate", "2", "--scene", "attic", "--out", "o"},     // no such room
      {"--simulate", "2", "--config", "/tmp", "--out", "o"},     // no file
      {"--robot", "teapot:x", "--out", "o"},                     // no such backend
      {"--robot", "simulated:office?legs=4", "--out", "o"},      //
      {"--robot", "replay:a", "--frames", "3", "--out", "o"},    // frames belong to --simulate
      {"--simulate", "0", "--out", "o"},                         //
  };
  for (const auto& arguments : wrong) {
    const auto parsed = parse_fleet_options(arguments);
    EXPECT_FALSE(parsed.value) << testing::PrintToString(arguments);
    EXPECT_EQ(parsed.exit, Exit::usage);
    EXPECT_FALSE(parsed.text.empty());
  }
}

TEST(LinkGraph, NamedGraphs) {
  using L = FleetLink;
  EXPECT_THAT(parse_graph("complete", 3).value(), ElementsAre(L{0, 1}, L{0, 2}, L{1, 2}));
  EXPECT_THAT(parse_graph("line", 4).value(), ElementsAre(L{0, 1}, L{1, 2}, L{2, 3}));
  EXPECT_THAT(parse_graph("ring", 4).value(), ElementsAre(L{0, 1}, L{0, 3}, L{1, 2}, L{2, 3}));
  EXPECT_THAT(parse_graph("ring", 2).value(), ElementsAre(L{0, 1}));
  EXPECT_THAT(parse_graph("star", 4).value(), ElementsAre(L{0, 1}, L{0, 2}, L{0, 3}));
  EXPECT_TRUE(parse_graph("complete", 1).value().empty());
}

TEST(LinkGraph, ListsAreSortedAndWithoutRepeats) {
  EXPECT_THAT(parse_graph("3-2,1-2,2-1", 3).value(), ElementsAre(FleetLink{0, 1}, FleetLink{1, 2}));
}

TEST(LinkGraph, RefusalsSayWhatIsWrong) {
  EXPECT_THAT(parse_graph("1-4", 3).error().text(), AllOf(HasSubstr("'1-4'"), HasSubstr("1..3")));
  EXPECT_THAT(parse_graph("2-2", 3).error().text(), HasSubstr("itself"));
  for (const char* wrong : {"", "1", "1-", "-1", "1-2,", ",1-2", "1-2-3", "0-1", "tree", "1-2;2-3", "1--2"})
    EXPECT_FALSE(parse_graph(wrong, 3).ok()) << wrong;
}

}  // namespace
}  // namespace onemap::daemon
