// People take links back: the maps part in every robot alike, and come together again when that is taken back.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/team_robots.hpp"

namespace onemap::mapping {
namespace {

using namespace std::chrono_literals;
using test::Author;
using test::kNow;
using test::link_of;
using test::Records;
using test::Robot;

RulingRecord apart(const Author& a, const Author& b, std::uint32_t turn = 1) {
  return {a.chain(), b.chain(), true, turn};
}
RulingRecord together(const Author& a, const Author& b, std::uint32_t turn) {
  return {a.chain(), b.chain(), false, turn};
}

std::vector<std::string> in_map(const Robot& robot) {
  std::vector<std::string> out;
  if (const SolutionRecord* solution = robot.map().solution())
    for (const SolvedRobot& solved : solution->robots) out.push_back(solved.chain.robot.name());
  return out;
}

struct RulingsTest : testing::Test {
  Author a = test::small_robot("a"), b = test::small_robot("b"), c = test::small_robot("c");
  Records all;
  void SetUp() override {
    a.link(link_of("a", "b"));
    b.link(link_of("b", "c"));
    for (const Author* author : {&a, &b, &c}) all.insert(all.end(), author->written().begin(), author->written().end());
  }
  TeamMember member(std::initializer_list<RecordPtr> records) {
    TeamMember out;
    for (const RecordPtr& record : records) EXPECT_TRUE(out.apply(record));
    return out;
  }
  static RecordPtr say(Author& author, const RulingRecord& ruling) {
    return author.write(Lane::poses, RecordKind::ruling, ruling);
  }
  // What the one publishes the other gets, until nobody has anything to say.
  static void talk(Robot& x, Robot& y, Instant from) {
    for (int s = 0; s < 6; ++s) {
      y.apply(x.work(from + std::chrono::seconds(2 * s)));
      x.apply(y.work(from + std::chrono::seconds(2 * s + 1)));
    }
  }
};

TEST_F(RulingsTest, TheHighestTurnCountsWhoeverSaidIt) {
  std::map<ChainId, TeamMember> members;
  members[a.chain()] = member({say(a, apart(a, b, 3))});
  members[b.chain()] = member({say(b, together(a, b, 2)), say(b, apart(b, c, 7)), say(b, together(b, c, 1))});
  const Rulings rulings(members);
  EXPECT_TRUE(rulings.apart(a.chain(), b.chain()));
  EXPECT_TRUE(rulings.apart(b.chain(), a.chain())) << "in whatever order one asks";
  EXPECT_EQ(rulings.find(a.chain(), b.chain())->by, a.chain());
  EXPECT_FALSE(rulings.apart(b.chain(), c.chain())) << "what a robot said last of a pair";
  EXPECT_EQ(rulings.find(a.chain(), c.chain()), nullptr);
}

TEST_F(RulingsTest, OfEqualTurnsThatOfTheHighestAuthorCounts) {
  std::map<ChainId, TeamMember> members;
  members[a.chain()] = member({say(a, apart(a, b, 2))});
  members[b.chain()] = member({say(b, together(a, b, 2))});
  EXPECT_FALSE(Rulings(members).apart(a.chain(), b.chain()));
}

TEST_F(RulingsTest, AMemberHasABoundedNumber) {
  TeamMember bounded;
  Author talker("t");
  for (std::uint64_t life = 1; life <= TeamMember::kMaxRulings; ++life)
    ASSERT_TRUE(bounded.apply(say(talker, {{a.id(), life}, {b.id(), 1}, true, 1})));
  EXPECT_FALSE(bounded.apply(say(talker, {{a.id(), 9999}, {b.id(), 1}, true, 1})));
  EXPECT_TRUE(bounded.apply(say(talker, {{a.id(), 1}, {b.id(), 1}, false, 2}))) << "one of these again";
}

TEST_F(RulingsTest, MapsPartAndComeTogetherAgainEverywhereAlike) {
  Robot decider(a, 10s), other(b, 10s);
  decider.apply(all), other.apply(all);
  talk(decider, other, kNow + 1s);
  EXPECT_THAT(in_map(decider), testing::ElementsAre("a", "b", "c"));
  const std::uint64_t before = decider.view().digest;
  ASSERT_EQ(other.view().digest, before);

  ASSERT_EQ(*other.map().unmerge(c.id(), b.id()), 1u);  // whoever of the two is named first
  talk(decider, other, kNow + 100s);
  EXPECT_THAT(in_map(decider), testing::ElementsAre("a", "b"));
  EXPECT_NE(decider.view().digest, before);
  EXPECT_EQ(other.view().digest, decider.view().digest);
  const auto told = decider.events<PairRuled>();
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0].by, b.id());
  EXPECT_TRUE(told[0].ruling.apart);

  ASSERT_EQ(*decider.map().merge(b.id(), c.id()), 1u);  // not only by who said it
  talk(decider, other, kNow + 200s);
  EXPECT_THAT(in_map(other), testing::ElementsAre("a", "b", "c"));
  EXPECT_EQ(decider.view().digest, before);
  EXPECT_EQ(other.view().digest, before);
}

// Two robots of one room, which without it are joined.
TEST(Rulings, TheFinalMapIsAFunctionOfTheRecordsWithTheRulings) {
  const Author& a = test::first();
  Author b = test::second();
  b.write(Lane::poses, RecordKind::ruling, RulingRecord{a.chain(), b.chain(), true, 1});
  Robot one(a), two(b);
  one.apply(a.written()), one.apply(b.written());
  two.apply(b.written()), two.apply(a.written());
  for (int i = 0; i < 3; ++i) one.apply(two.work()), two.apply(one.work());
  for (const Robot* robot : {&one, &two}) {
    EXPECT_TRUE(robot->view().settled) << "who is ruled apart need not be verified";
    EXPECT_THAT(in_map(*robot), testing::ElementsAre("robot1"));
    EXPECT_TRUE(robot->map().links().empty());
  }
  EXPECT_NE(one.view().digest, 0u);
  EXPECT_EQ(one.view().digest, two.view().digest);
}

TEST_F(RulingsTest, WhatDoesNotHoldIsSaid) {
  Robot robot(a, 10s);
  robot.apply(all);
  robot.work(kNow + 1s);
  EXPECT_EQ(robot.map().unmerge(a.id(), c.id()).error().text(), "a and c: no link joins them");
  EXPECT_EQ(robot.map().merge(a.id(), b.id()).error().text(), "a and b: nobody has taken their links back");
  EXPECT_EQ(robot.map().unmerge(a.id(), RobotId::from_name("z")).error().text(), "robot z: is not known here");
  EXPECT_TRUE(robot.map().take_records().empty());
}

TEST_F(RulingsTest, WhySaysWhatJoinsAndOverWhom) {
  Robot robot(a, 10s);
  robot.apply(all);
  robot.work(kNow + 1s);
  const Why direct = *robot.map().why(b.id(), a.id());
  EXPECT_TRUE(direct.one_map);
  EXPECT_THAT(direct.way, testing::ElementsAre(b.chain(), a.chain()));
  ASSERT_EQ(direct.pairs.size(), 1u);
  const WhyPair& pair = direct.pairs[0];
  EXPECT_EQ(pair.a, a.chain());
  EXPECT_EQ(pair.b, b.chain());
  EXPECT_EQ(pair.link->inliers, 100u);
  EXPECT_EQ(pair.verdict.reason, JoinReason::joined);
  EXPECT_EQ(pair.pairs.at(LinkUse::used), 9u);
  EXPECT_LT(pair.worst, 1);
  EXPECT_FALSE(pair.ruling);

  const Why indirect = *robot.map().why(a.id(), c.id());
  EXPECT_TRUE(indirect.one_map);
  EXPECT_THAT(indirect.way, testing::ElementsAre(a.chain(), b.chain(), c.chain()));
  ASSERT_EQ(indirect.pairs.size(), 1u) << "it has looked itself, which no record says while robots map";
  EXPECT_EQ(indirect.pairs[0].link->reason, LinkReason::too_few_matches);
}

TEST_F(RulingsTest, WhyNamesWhoTookALinkBack) {
  Robot robot(a, 10s), next(b, 10s);
  robot.apply(all), next.apply(all);
  talk(robot, next, kNow + 1s);
  ASSERT_TRUE(robot.map().unmerge(a.id(), b.id()));
  talk(robot, next, kNow + 100s);
  EXPECT_THAT(in_map(robot), testing::ElementsAre("b", "c")) << "the larger group is the map";
  const Why why = *robot.map().why(a.id(), b.id());
  EXPECT_FALSE(why.one_map);
  EXPECT_TRUE(why.way.empty());
  ASSERT_EQ(why.pairs.size(), 1u);
  EXPECT_TRUE(why.pairs[0].ruling->apart);
  EXPECT_EQ(why.pairs[0].ruling->by, a.chain());
  EXPECT_EQ(why.pairs[0].verdict.reason, JoinReason::no_links);
  EXPECT_TRUE(why.pairs[0].link) << "what was verified is still told";
}

TEST(RulingRecord, RefusesWhatCannotBe) {
  const ChainId a{RobotId::from_name("a"), 1}, b{RobotId::from_name("b"), 1};
  const auto reason = [](const RulingRecord& record) { return decode_ruling(encode(record)).error().text(); };
  EXPECT_EQ(reason({b, a, true, 1}), "ruling record, b: before a");
  EXPECT_EQ(reason({a, b, true, 0}), "ruling record, turn: not from 1 to 2^31");
  EXPECT_EQ(reason({a, b, true, kMostTurns + 1}), "ruling record, turn: not from 1 to 2^31");
  auto body = encode(RulingRecord{a, b, true, 1});
  body[body.size() - 5] = 2;
  EXPECT_EQ(decode_ruling(body).error().text(), "ruling record, apart: neither 0 nor 1");
}

}  // namespace
}  // namespace onemap::mapping
