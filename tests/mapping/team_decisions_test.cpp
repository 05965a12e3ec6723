// Who decides what the team's map is, and whom nobody believes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/team_robots.hpp"

namespace onemap::mapping {
namespace {

using namespace std::chrono_literals;
using test::Author;
using test::kNow;
using test::listener;
using test::Robot;

// Small robots whose links are written by hand: what counts is who decides.
struct Decisions : testing::Test {
  Author a = test::small_robot("a"), b = test::small_robot("b"), c = test::small_robot("c");
  Robot robot{listener()};
  SolutionRecord right;

  void SetUp() override {
    a.link(test::link_of("a", "b", 100));
    a.link(test::link_of("a", "c", 50));
    b.link(test::link_of("b", "c", 70));
    TeamLog log(listener().id(), 1);
    for (Author* author : {&a, &b, &c}) {
      author->finish();
      robot.apply(author->written());
      for (const RecordPtr& record : author->written()) ASSERT_TRUE(log.apply(record, kNow).ok());
    }
    right = solve_team(log, log.chains());
    right.map = map_parameters(test::small_map());
  }
};

TEST_F(Decisions, OnlyWhatTheLinksSayIsFused) {
  SolutionRecord wrong = right;
  wrong.robots.back().anchors[1].T_map_anchor.t_10um[0] += 2000;  // two centimetres
  robot.apply(a.solution(wrong));
  robot.work();
  EXPECT_EQ(robot.view().digest, 0u);
  ASSERT_EQ(robot.view().waiting.size(), 1u);
  EXPECT_EQ(robot.view().waiting[0].robot, a.id());
  EXPECT_EQ(robot.view().waiting[0].what, Waiting::What::solution);
  robot.apply(a.solution(right));
  robot.work();
  EXPECT_TRUE(robot.view().settled);
  EXPECT_TRUE(robot.events<DeciderPassedOver>().empty());
}

TEST_F(Decisions, NobodyElsesSolutionCounts) {
  robot.apply(b.solution(right));
  robot.work();
  EXPECT_FALSE(robot.view().settled);
  EXPECT_EQ(robot.view().digest, 0u);
}

TEST_F(Decisions, WhoDecidesWronglyForLongIsPassedOver) {
  SolutionRecord wrong = right;
  wrong.robots.back().anchors[1].T_map_anchor.t_10um[0] += 2000;  // two centimetres
  robot.apply(a.solution(wrong));
  robot.apply(b.solution(right));
  robot.work(kNow + 60s);
  EXPECT_FALSE(robot.view().settled);
  robot.work(kNow + 121s);
  robot.work(kNow + 122s);
  EXPECT_TRUE(robot.view().settled) << "the next one's counts";
  const auto passed = robot.events<DeciderPassedOver>();
  ASSERT_EQ(passed.size(), 1u);
  EXPECT_EQ(passed[0].robot, a.id());
  EXPECT_TRUE(passed[0].published);
}

TEST_F(Decisions, AStrangerThatSortsFirstDecidesNothing) {
  Author evil("-evil");
  evil.hello();
  SubmapRecord broken{0, 20000, 60000, {{{100, 0, 0}, {}}}};
  broken.blocks[0].voxels[7] = {2 * kTsdfOne, 1, {}};
  evil.write(Lane::voxels, RecordKind::submap, broken);
  const SolutionRecord own = alone_on_map(evil.chain());
  evil.solution(own);
  evil.write(Lane::control, RecordKind::finished, FinishedRecord{0, 0, 0, 1});
  robot.apply(evil.written());
  robot.work();
  EXPECT_EQ(robot.view().digest, 0u) << "nobody who counts has decided";
  robot.apply(a.solution(right));
  robot.work();
  EXPECT_TRUE(robot.view().settled);
  ASSERT_NE(robot.map().solution(), nullptr);
  EXPECT_EQ(encode(*robot.map().solution()), encode(right));
  EXPECT_EQ(robot.view().records_refused, 0u) << "what is not in the map is never decoded";
}

TEST_F(Decisions, ARecordInThisRobotsNameIsRefusedCountedAndSaid) {
  Robot victim(a);
  for (const Author* author : {&a, &b}) victim.apply(author->written());
  victim.work();
  ASSERT_TRUE(victim.view().settled);
  const std::uint64_t digest = victim.view().digest;
  Author forged("a", ~std::uint64_t{0});
  victim.apply(forged.hello());
  victim.apply(forged.finish());
  victim.work();
  EXPECT_TRUE(victim.view().settled);
  EXPECT_EQ(victim.view().digest, digest);
  EXPECT_EQ(victim.view().records_refused, 2u);
  ASSERT_EQ(victim.events<RecordRefused>().size(), 2u);
  EXPECT_THAT(victim.events<RecordRefused>()[0].reason, testing::HasSubstr("in this robot's own name"));
}

TEST_F(Decisions, UnderAnotherNumberThisRobotsRecordsComeAgain) {
  Robot self(a);
  for (const Author* author : {&a, &b}) self.apply(author->written());
  self.work();
  ASSERT_TRUE(self.view().settled);
  self.map().begin_life(7, true);
  EXPECT_FALSE(self.view().settled);
  EXPECT_EQ(self.map().members().count(a.chain()), 0u);
  for (RecordPtr record : self.held())
    if (record->id.log.robot == a.id()) {
      Record again = *record;
      again.id.log.incarnation = 7;
      self.map().apply(std::make_shared<const Record>(std::move(again)), kNow);
    }
  EXPECT_EQ(self.map().members().at({a.id(), 7}).incarnation, 7u);
  EXPECT_EQ(self.map().members().at({a.id(), 7}).keyframes.size(), 3u);
}

}  // namespace
}  // namespace onemap::mapping
