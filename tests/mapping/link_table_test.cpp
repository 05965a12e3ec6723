#include "mapping/team/link_table.hpp"

#include <gtest/gtest.h>

#include "support/team_author.hpp"

namespace onemap::mapping {
namespace {

using test::Author;
using test::link_of;

// Two robots with three keyframes each.
struct LinkTable : testing::Test {
  Author a = test::small_robot("a"), b = test::small_robot("b");
  TeamLog log{RobotId::from_name("self"), 1};

  void take(const RecordPtr& record) { ASSERT_TRUE(log.apply(record, Instant{}).ok()); }
  void take(const Author& author) {
    for (const auto& record : author.written()) take(record);
  }
  void SetUp() override {
    take(a);
    take(b);
  }
  const LinkRecord* between() const { return link_between(log, log.present(a.id()), log.present(b.id())); }
};

TEST_F(LinkTable, TheLastLinkOfTheLowerRobotCounts) {
  EXPECT_EQ(between(), nullptr);
  take(a.link(link_of("a", "b", 50)));
  take(a.link(link_of("a", "b", 70)));
  ASSERT_NE(between(), nullptr);
  EXPECT_EQ(between()->inliers, 70u);
  EXPECT_EQ(link_between(log, b.chain(), a.chain()), between()) << "a pair has no order";
  EXPECT_TRUE(covers(*between(), *log.find(a.id()), *log.find(b.id())));
  EXPECT_EQ(counting_links(log).size(), 1u);
}

TEST_F(LinkTable, TheOtherRobotsLinkCountsWhenItLookedAtMore) {
  LinkRecord early = link_of("a", "b", 50);
  early.keyframes_a = 1;
  take(a.link(early));
  take(b.link(link_of("a", "b", 70)));
  EXPECT_EQ(between()->inliers, 70u);
  take(a.link(link_of("a", "b", 60)));
  EXPECT_EQ(between()->inliers, 60u) << "of equal looks the lower robot's counts";
}

TEST_F(LinkTable, WhoClaimsToHaveSeenMoreThanThereIsDoesNotOverrule) {
  take(a.link(link_of("a", "b", 50, LinkReason::too_few_matches)));
  LinkRecord lie = link_of("a", "b", 900);
  lie.keyframes_a = 4;
  take(b.link(lie));
  EXPECT_EQ(between()->reason, LinkReason::too_few_matches);
}

TEST_F(LinkTable, LinksNameTheLivesThatTheyAreOf) {
  take(a.link(link_of("a", "b", 50)));
  take(b.link(link_of("a", "b", 70)));
  take(test::small_robot("b", 2));
  EXPECT_EQ(between(), nullptr) << "both are of the former life of b";
  LinkRecord again = link_of("a", "b", 80);
  again.incarnation_other = 2;
  take(a.link(again));
  ASSERT_NE(between(), nullptr);
  EXPECT_EQ(between()->inliers, 80u);
  EXPECT_EQ(link_between(log, a.chain(), b.chain())->inliers, 50u) << "the former life keeps its own";
  EXPECT_EQ(counting_links(log).size(), 2u);
  take(test::small_robot("a", 2));
  EXPECT_EQ(between(), nullptr);
  EXPECT_EQ(counting_links(log).size(), 2u);
}

TEST_F(LinkTable, TwoLivesOfOneRobotAreLinkedByTheLater) {
  Author again = test::small_robot("a", 2);
  LinkRecord link = link_of("a", "a", 60);
  take(again);
  take(again.link(link));
  const ChainId first = a.chain(), second = again.chain();
  ASSERT_NE(link_between(log, first, second), nullptr);
  EXPECT_EQ(link_between(log, first, second)->inliers, 60u);
  ASSERT_EQ(counting_links(log).size(), 1u);
  EXPECT_EQ(counting_links(log)[0].a, first);
  EXPECT_EQ(counting_links(log)[0].b, second);
  EXPECT_EQ(counting_loops(log).size(), 3u) << "and each has its own loops";
}

TEST_F(LinkTable, RobotsThatDoNotCountHaveNoLinks) {
  Author mute("c");
  take(mute.keyframe());
  LinkRecord link = link_of("a", "c");
  take(a.link(link));
  EXPECT_NE(link_between(log, a.chain(), mute.chain()), nullptr);
  EXPECT_TRUE(counting_links(log).empty()) << "c has not greeted";
}

}  // namespace
}  // namespace onemap::mapping
