#include "mapping/team/election.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/team_author.hpp"

namespace onemap::mapping {
namespace {

using test::link_of;
using testing::ElementsAre;

RobotId id(const char* name) { return RobotId::from_name(name); }
bool anyone(const RobotId&) { return true; }

TEST(Election, IslandsAreWhatAcceptedLinksJoin) {
  const std::vector<RobotId> robots{id("-evil"), id("a"), id("b"), id("c"), id("d")};
  const std::vector<LinkRecord> links{link_of("c", "d"), link_of("a", "c"), link_of("b", "d"),
                                      link_of("-evil", "a", 900, LinkReason::inconsistent), link_of("a", "nobody")};
  EXPECT_THAT(islands(robots, links),
              ElementsAre(ElementsAre(id("a"), id("b"), id("c"), id("d")), ElementsAre(id("-evil"))));
}

TEST(Election, TheLowestIdDecidesWhenNobodyIsLinked) {
  const std::vector<RobotId> robots{id("c"), id("a"), id("b")};
  EXPECT_EQ(elect(islands(robots, {}), anyone), id("a"));
}

TEST(Election, WhoIsNotInTheMapDoesNotDecide) {
  const std::vector<RobotId> robots{id("-evil"), id("a"), id("b")};
  const std::vector<LinkRecord> links{link_of("a", "b")};
  EXPECT_EQ(elect(islands(robots, links), anyone), id("a"));
}

TEST(Election, TheNextTakesOver) {
  const std::vector<RobotId> robots{id("-evil"), id("a"), id("b")};
  const std::vector<LinkRecord> links{link_of("a", "b")};
  const auto all = islands(robots, links);
  EXPECT_EQ(elect(all, [](const RobotId& robot) { return robot != id("a"); }), id("b"));
  EXPECT_EQ(elect(all, [](const RobotId& robot) { return robot == id("-evil"); }), id("-evil"));
  EXPECT_EQ(elect(all, [](const RobotId&) { return false; }), std::nullopt);
}

TEST(Election, OfEqualIslandsTheLowestIdCounts) {
  const std::vector<RobotId> robots{id("a"), id("b"), id("c"), id("d")};
  const std::vector<LinkRecord> links{link_of("b", "d"), link_of("a", "c")};
  EXPECT_THAT(islands(robots, links), ElementsAre(ElementsAre(id("a"), id("c")), ElementsAre(id("b"), id("d"))));
}

}  // namespace
}  // namespace onemap::mapping
