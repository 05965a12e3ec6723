#include "mapping/team/decision.hpp"

#include <gtest/gtest.h>

#include "support/team_author.hpp"

namespace onemap::mapping {
namespace {

using namespace std::chrono_literals;
using test::Author;
using test::link_of;

constexpr Instant kDecisionStart{};

// a, b and c are linked and have finished; "-evil" has no link. Seen by c.
struct DecisionTest : testing::Test {
  Author evil{"-evil"}, a = test::small_robot("a"), b = test::small_robot("b"), c = test::small_robot("c");
  TeamLog log{c.id(), 1};
  Presence presence{c.id(), 100s};
  Decision decision{10s};
  TeamSolver solver{MapParameters{}};
  SolutionRecord right;

  void take(const RecordPtr& record) { ASSERT_TRUE(log.apply(record, kDecisionStart).ok()); }
  void SetUp() override {
    evil.hello();
    a.link(link_of("a", "b", 100));
    a.link(link_of("a", "c", 50));
    b.link(link_of("b", "c", 70));
    for (Author* author : {&evil, &a, &b, &c}) {
      author->finish();
      for (const auto& record : author->written()) take(record);
    }
    right = solve_team(log, log.chains());
  }
  // Everybody but the silent has just been heard.
  Agreement at(Duration by, const std::set<RobotId>& silent = {}) {
    std::map<RobotId, Instant> last_sign;
    for (const RobotId& robot : log.robots())
      if (!silent.contains(robot)) last_sign[robot] = kDecisionStart + by;
    presence.update(last_sign, {});
    return {log, presence, kDecisionStart + by};
  }
};

TEST_F(DecisionTest, TheLowestOfTheMapDecides) {
  EXPECT_EQ(decision.decider(at(1s)), a.id());
  take(b.solution(right));
  take(evil.solution(alone_on_map(evil.chain())));
  EXPECT_FALSE(decision.made(at(1s), solver));
  take(a.solution(right));
  EXPECT_TRUE(decision.made(at(1s), solver));
}

TEST_F(DecisionTest, WhatTheLinksDoNotSayIsNoDecision) {
  SolutionRecord wrong = right;
  for (auto& solved : wrong.robots)
    if (solved.chain != wrong.reference) solved.anchors[1].T_map_anchor.t_10um[1] += 2000;
  take(a.solution(wrong));
  EXPECT_FALSE(decision.made(at(1s), solver));
}

TEST_F(DecisionTest, WhenTheDeciderIsGoneTheNextDecidesAndWhatItDecidedStays) {
  EXPECT_EQ(decision.decider(at(101s, {a.id()})), b.id());
  EXPECT_FALSE(decision.made(at(101s, {a.id()}), solver));
  take(a.solution(right));
  EXPECT_TRUE(decision.made(at(101s, {a.id()}), solver));
}

TEST_F(DecisionTest, WhoDoesNotDecideIsPassedOverAfterAWhile) {
  EXPECT_FALSE(decision.look(at(0s), true, solver, kDecisionStart));
  EXPECT_FALSE(decision.look(at(10s), true, solver, kDecisionStart + 10s));
  const auto passed = decision.look(at(11s), true, solver, kDecisionStart + 11s);
  ASSERT_TRUE(passed.has_value());
  EXPECT_EQ(passed->robot, a.id());
  EXPECT_FALSE(passed->published);
  EXPECT_EQ(decision.decider(at(11s)), b.id());
  take(a.solution(right));
  EXPECT_TRUE(decision.made(at(12s), solver)) << "late is not wrong";
  EXPECT_FALSE(decision.look(at(30s), true, solver, kDecisionStart + 30s)) << "it has been decided";
  EXPECT_FALSE(decision.look(at(31s), false, solver, kDecisionStart + 31s));
  EXPECT_EQ(decision.decider(at(31s)), a.id()) << "when all begins again, so does its turn";
}

// While robots map a solution is looked at once; what was refuted is looked at again after a while.
TEST_F(DecisionTest, WhileRobotsMapASolutionIsLookedAtOnce) {
  take(a.keyframe());  // one more than it promised, so that the pairs are not verified
  ASSERT_FALSE(at(1s).ready());
  SolutionRecord wrong = right;
  for (auto& solved : wrong.robots)
    if (solved.chain != wrong.reference) solved.anchors[1].T_map_anchor.t_10um[1] += 2000;
  take(a.solution(wrong));
  EXPECT_FALSE(decision.made(at(1s), solver));
  const std::uint64_t solved = solver.solved();
  EXPECT_FALSE(decision.made(at(2s), solver));
  EXPECT_EQ(solver.solved(), solved);
  take(a.solution(right));
  EXPECT_EQ(decision.made(at(2s), solver), log.find(a.id()));
  const std::uint64_t once = solver.solved();
  take(a.keyframe());
  EXPECT_TRUE(decision.made(at(3s), solver));
  EXPECT_EQ(solver.solved(), once);
}

TEST_F(DecisionTest, ThisRobotItselfIsNotPassedOver) {
  decision.look(at(0s), true, solver, kDecisionStart);
  decision.look(at(11s), true, solver, kDecisionStart + 11s);
  decision.look(at(12s), true, solver, kDecisionStart + 12s);
  EXPECT_TRUE(decision.look(at(23s), true, solver, kDecisionStart + 23s)) << "b";
  EXPECT_EQ(decision.decider(at(24s)), c.id());
  decision.look(at(24s), true, solver, kDecisionStart + 24s);
  EXPECT_FALSE(decision.look(at(90s), true, solver, kDecisionStart + 90s));
}

}  // namespace
}  // namespace onemap::mapping
