#include "mapping/team/election.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/team_author.hpp"

namespace onemap::mapping {
namespace {

using test::link_of;
using testing::ElementsAre;

RobotId id(const char* name) { return RobotId::from_name(name); }
ChainId life(const char* name, std::uint64_t incarnation = 1) { return {id(name), incarnation}; }
bool anyone(const ChainId&) { return true; }

// Links between first lives.
struct Links {
  explicit Links(std::vector<LinkRecord> links) : records(std::move(links)) {
    for (const LinkRecord& link : records) all.push_back({{link.a, 1}, {link.b, 1}, &link});
  }
  std::vector<LinkRecord> records;
  std::vector<TeamLink> all;
};

TEST(Election, IslandsAreWhatAcceptedLinksJoin) {
  const std::vector<ChainId> robots{life("-evil"), life("a"), life("b"), life("c"), life("d")};
  const Links links({link_of("c", "d"), link_of("a", "c"), link_of("b", "d"),
                     link_of("-evil", "a", 900, LinkReason::inconsistent), link_of("a", "nobody")});
  EXPECT_THAT(islands(robots, links.all),
              ElementsAre(ElementsAre(life("a"), life("b"), life("c"), life("d")), ElementsAre(life("-evil"))));
}

TEST(Election, TheLowestIdDecidesWhenNobodyIsLinked) {
  const std::vector<ChainId> robots{life("c"), life("a"), life("b")};
  EXPECT_EQ(elect(islands(robots, {}), anyone), id("a"));
}

TEST(Election, WhoIsNotInTheMapDoesNotDecide) {
  const std::vector<ChainId> robots{life("-evil"), life("a"), life("b")};
  const Links links({link_of("a", "b")});
  EXPECT_EQ(elect(islands(robots, links.all), anyone), id("a"));
}

TEST(Election, TheNextTakesOver) {
  const std::vector<ChainId> robots{life("-evil"), life("a"), life("b")};
  const Links links({link_of("a", "b")});
  const auto all = islands(robots, links.all);
  EXPECT_EQ(elect(all, [](const ChainId& chain) { return chain != life("a"); }), id("b"));
  EXPECT_EQ(elect(all, [](const ChainId& chain) { return chain == life("-evil"); }), id("-evil"));
  EXPECT_EQ(elect(all, [](const ChainId&) { return false; }), std::nullopt);
}

TEST(Election, OfEqualIslandsTheLowestIdCounts) {
  const std::vector<ChainId> robots{life("a"), life("b"), life("c"), life("d")};
  const Links links({link_of("b", "d"), link_of("a", "c")});
  EXPECT_THAT(islands(robots, links.all),
              ElementsAre(ElementsAre(life("a"), life("c")), ElementsAre(life("b"), life("d"))));
}

// What joins a robot's earlier life to others joins it to them, if its present one is joined to that.
TEST(Election, EarlierLivesJoin) {
  const std::vector<ChainId> robots{life("a"), life("a", 2), life("b"), life("c")};
  const LinkRecord link = link_of("a", "b");
  const std::vector<TeamLink> links{{life("a"), life("b"), &link}, {life("a"), life("a", 2), &link}};
  EXPECT_THAT(islands(robots, links),
              ElementsAre(ElementsAre(life("a"), life("a", 2), life("b")), ElementsAre(life("c"))));
}

}  // namespace
}  // namespace onemap::mapping
