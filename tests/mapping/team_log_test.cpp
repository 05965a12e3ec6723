#include "mapping/team/team_log.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/team_author.hpp"

namespace onemap::mapping {
namespace {

using test::Author;
using testing::HasSubstr;

constexpr Instant kLogNow{};
const RobotId kSelf = RobotId::from_name("self");

TEST(TeamLog, EachLifeIsAChainAndTheNewestIsThePresentOne) {
  const Author first = test::small_robot("a", 1), second = test::small_robot("a", 2);
  TeamLog in_order(kSelf, 1), reversed(kSelf, 1);
  for (const Author* author : {&first, &second})
    for (const auto& record : author->written()) EXPECT_TRUE(*in_order.apply(record, kLogNow));
  for (const Author* author : {&second, &first})
    for (const auto& record : author->written()) EXPECT_TRUE(*reversed.apply(record, kLogNow));
  for (const TeamLog* log : {&in_order, &reversed}) {
    EXPECT_THAT(log->chains(), testing::ElementsAre(first.chain(), second.chain()));
    EXPECT_THAT(log->robots(), testing::ElementsAre(first.id()));
    EXPECT_EQ(log->present(first.id()), second.chain());
    EXPECT_EQ(log->find(first.id())->incarnation, 2u);
    EXPECT_EQ(log->find(first.chain())->keyframes.size(), 3u) << "an earlier life keeps its worth";
  }
}

TEST(TeamLog, ALifeThatALaterOneRepeatsDoesNotCount) {
  const Author first = test::small_robot("a", 1);
  Author second("a", 2);
  second.write(Lane::control, RecordKind::hello, HelloRecord{"a", "", 1});
  TeamLog log(kSelf, 1);
  for (const auto& record : first.written()) EXPECT_TRUE(*log.apply(record, kLogNow));
  EXPECT_THAT(log.chains(), testing::ElementsAre(first.chain()));
  for (const auto& record : second.written()) EXPECT_TRUE(*log.apply(record, kLogNow));
  EXPECT_THAT(log.chains(), testing::ElementsAre(second.chain()));
}

TEST(TeamLog, OfTooManyLivesTheNewestCountInAnyOrder) {
  for (const bool falling : {false, true}) {
    TeamLog log(kSelf, 1);
    const std::uint64_t lives = TeamLog::kMaxLives + 3;
    for (std::uint64_t i = 1; i <= lives; ++i)
      EXPECT_TRUE(log.apply(Author("a", falling ? lives + 1 - i : i).hello(), kLogNow).ok());
    ASSERT_EQ(log.chains().size(), TeamLog::kMaxLives);
    EXPECT_EQ(log.chains().front().incarnation, 4u);
    EXPECT_EQ(log.chains().back().incarnation, lives);
  }
}

TEST(TeamLog, NobodyElseWritesForThisRobot) {
  TeamLog log(kSelf, 5);
  for (const auto& record : test::small_robot("self", 5).written()) EXPECT_TRUE(*log.apply(record, kLogNow));
  for (const std::uint64_t life : {std::uint64_t{6}, ~std::uint64_t{0}}) {
    const auto taken = log.apply(test::small_robot("self", life).written()[0], kLogNow);
    ASSERT_FALSE(taken.ok());
    EXPECT_THAT(taken.error().text(), HasSubstr("in this robot's own name"));
  }
  EXPECT_TRUE(*log.apply(test::small_robot("self", 4).written()[0], kLogNow))
      << "an earlier life of its own is no forgery";
  EXPECT_EQ(log.chains().size(), 2u);
  EXPECT_EQ(log.find(kSelf)->incarnation, 5u);
  EXPECT_EQ(log.find(kSelf)->keyframes.size(), 3u);
}

TEST(TeamLog, ThisRobotItselfBeginsANewLife) {
  TeamLog log(kSelf, 5);
  for (const auto& record : test::small_robot("self", 5).written()) EXPECT_TRUE(*log.apply(record, kLogNow));
  log.begin_life(9, true);
  EXPECT_EQ(log.find(kSelf), nullptr);
  EXPECT_FALSE(*log.apply(test::small_robot("self", 5).written()[0], kLogNow)) << "it is repeated";
  for (const auto& record : test::small_robot("self", 9).written()) EXPECT_TRUE(*log.apply(record, kLogNow));
  EXPECT_EQ(log.find(kSelf)->incarnation, 9u);
}

TEST(TeamLog, ThisRobotGoesOnInAnotherChain) {
  TeamLog log(kSelf, 5);
  for (const auto& record : test::small_robot("self", 5).written()) EXPECT_TRUE(*log.apply(record, kLogNow));
  log.begin_life(6, false);
  EXPECT_EQ(log.own(), nullptr) << "nothing of it yet";
  EXPECT_EQ(log.chains().size(), 1u) << "and what came before counts";
  for (const auto& record : test::small_robot("self", 6).written()) EXPECT_TRUE(*log.apply(record, kLogNow));
  EXPECT_EQ(log.chains().size(), 2u);
  EXPECT_EQ(log.own()->incarnation, 6u);
}

TEST(TeamLog, RobotsWithoutAValidNameOrGreetingDoNotCount) {
  TeamLog log(kSelf, 1);
  for (const char* name : {"../../PWNED", "a/b", "..", "\xff\x1b[31m"})
    EXPECT_FALSE(log.apply(Author(name).keyframe(), kLogNow).ok()) << name;
  EXPECT_TRUE(log.members().empty());
  EXPECT_TRUE(*log.apply(Author("quiet").keyframe(), kLogNow));
  Author liar("liar");
  EXPECT_FALSE(log.apply(liar.write(Lane::control, RecordKind::hello, HelloRecord{"other", ""}), kLogNow).ok());
  Author honest("honest");
  EXPECT_TRUE(*log.apply(honest.hello(), kLogNow));
  EXPECT_THAT(log.robots(), testing::ElementsAre(honest.id()));
}

TEST(TeamLog, ATeamHasABoundedNumberOfRobots) {
  TeamLog log(kSelf, 1);
  for (std::size_t i = 0; i < TeamLog::kMaxRobots; ++i)
    EXPECT_TRUE(*log.apply(Author(fmt::format("r{}", i)).hello(), kLogNow));
  const auto taken = log.apply(Author("one-more").hello(), kLogNow);
  ASSERT_FALSE(taken.ok());
  EXPECT_THAT(taken.error().text(), HasSubstr("one robot more"));
  EXPECT_TRUE(*log.apply(Author("r7", 2).hello(), kLogNow)) << "a known one may start anew";
  EXPECT_EQ(log.robots().size(), TeamLog::kMaxRobots);
}

TEST(TeamLog, RemembersWhenARobotsLastRecordCame) {
  TeamLog log(kSelf, 1);
  Author author("a");
  EXPECT_TRUE(*log.apply(author.hello(), kLogNow));
  EXPECT_TRUE(*log.apply(author.keyframe(), kLogNow + std::chrono::seconds(7)));
  EXPECT_EQ(log.find(author.id())->heard, kLogNow + std::chrono::seconds(7));
}

}  // namespace
}  // namespace onemap::mapping
