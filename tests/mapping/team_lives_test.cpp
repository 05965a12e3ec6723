// Robots that start anew, die and come back.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <set>

#include "mapping/team/placed_anchors.hpp"
#include "support/team_robots.hpp"

namespace onemap::mapping {
namespace {

using namespace std::chrono_literals;
using test::Author;
using test::explore;
using test::first;
using test::kNow;
using test::listener;
using test::Records;
using test::Robot;
using test::second;
using test::shuffled;
using test::stranger;
using test::Team;
using test::whole_team;

// robot2 was switched off and on again: its earlier life stays in the map, and its later one finds itself in it.
TEST(TeamLives, AnEarlierLifeKeepsItsWorth) {
  const Author reborn = explore("robot2", "simulated:living-room?robot=2&robots=3&frames=90&seed=3", 2);
  Team team({&first(), &reborn}, second().written());
  team.work();
  const Robot& robot1 = team.robots()[0];
  const std::uint64_t digest = robot1.view().digest;
  for (const Robot& robot : team.robots()) {
    EXPECT_TRUE(robot.view().settled);
    EXPECT_EQ(robot.view().digest, digest);
    EXPECT_EQ(robot.view().robots_known, 2u);
    EXPECT_EQ(robot.view().robots_in_map, 2u);
    ASSERT_NE(robot.map().solution(), nullptr);
    EXPECT_EQ(robot.map().solution()->robots.size(), 3u) << "three chains";
  }
  // The two lives walked one way from one place, so in the map they are where each other is.
  const SolutionRecord& solution = *robot1.map().solution();
  const auto at = [&](const ChainId& chain) {
    const TeamMember& member = *robot1.map().log().find(chain);
    return from_quantized(placed_anchors(member, *find_solved(solution, chain))[0].T_map_anchor).t;
  };
  EXPECT_LT((at(second().chain()) - at(reborn.chain())).norm(), 0.02);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Robot robot(listener());
    robot.apply(shuffled(team.all(), seed));
    robot.work();
    EXPECT_TRUE(robot.view().settled);
    EXPECT_EQ(robot.view().digest, digest);
  }
}

// What robot1 wrote when it died: no Finished, and its last submap is nowhere. It is the lowest id: it would verify its
// pairs and decide.
Records of_the_dead() {
  Records out;
  for (const RecordPtr& record : first().written())
    if (record->kind != static_cast<std::uint16_t>(RecordKind::finished)) out.push_back(record);
  const auto last = std::find_if(out.rbegin(), out.rend(), [](const RecordPtr& record) {
    return record->kind == static_cast<std::uint16_t>(RecordKind::submap);
  });
  out.erase(std::next(last).base());
  return out;
}

// robot1 is dead; robot2 and robot3 hold what it wrote.
struct WithoutTheFirst : testing::Test {
  Team team{{&second(), &stranger()}, of_the_dead()};
  const std::set<RobotId> silent{first().id()};
};

TEST_F(WithoutTheFirst, ItIsWaitedForAWhile) {
  team.work(kNow + 50s, silent);
  for (const Robot& robot : team.robots()) {
    EXPECT_FALSE(robot.view().settled);
    EXPECT_TRUE(robot.view().gone.empty());
    ASSERT_EQ(robot.view().waiting.size(), 1u);
    EXPECT_EQ(robot.view().waiting[0].robot, first().id());
    EXPECT_EQ(robot.view().waiting[0].what, Waiting::What::end);
    EXPECT_EQ(robot.view().waiting[0].silent, Duration(50s));
  }
}

TEST_F(WithoutTheFirst, TheNextDoesItsWork) {
  team.work(kNow + 50s, silent);
  team.work(kNow + 61s, silent);
  const std::uint64_t digest = team.robots()[0].view().digest;
  for (const Robot& robot : team.robots()) {
    EXPECT_TRUE(robot.view().settled);
    EXPECT_TRUE(robot.view().waiting.empty());
    EXPECT_THAT(robot.view().gone, testing::ElementsAre(first().id()));
    EXPECT_THAT(robot.view().cut_short, testing::ElementsAre(first().id()));
    EXPECT_EQ(robot.events<RobotGone>().size(), 1u);
    EXPECT_EQ(robot.view().digest, digest);
    EXPECT_EQ(robot.view().robots_in_map, 2u) << "what the dead one had written is in the map";
  }
  // A robot that never heard it alive holds the same map from the same records.
  Robot late(listener());
  late.apply(shuffled(team.all(), 3));
  late.work(kNow + 1000s, silent);
  EXPECT_TRUE(late.view().settled);
  EXPECT_EQ(late.view().digest, digest);
}

// With the rest of what it wrote, and the team ends as if nothing had been.
TEST_F(WithoutTheFirst, ItComesBack) {
  team.work(kNow + 50s, silent);
  team.work(kNow + 61s, silent);
  Robot& decider = team.robots()[0];
  std::set<RecordId> known;
  for (const RecordPtr& record : decider.held()) known.insert(record->id);
  Robot alive(first());
  alive.apply(first().written());
  for (const RecordPtr& record : team.all())
    if (record->id.log.robot != first().id()) alive.apply(record);
  const Instant now = kNow + 70s;
  for (const RecordPtr& record : alive.held())
    if (!known.contains(record->id)) decider.apply(record, now);
  decider.work(now);
  EXPECT_TRUE(decider.view().gone.empty());
  EXPECT_FALSE(decider.view().settled) << "its link is its own work again";
  for (const RecordPtr& record : alive.work(now)) decider.apply(record, now);
  decider.work(now);
  Robot expected(listener());
  expected.apply(whole_team({&first(), &second(), &stranger()}));
  expected.work();
  EXPECT_TRUE(decider.view().settled);
  EXPECT_EQ(decider.view().digest, expected.view().digest);
  EXPECT_EQ(decider.events<RobotBack>().size(), 1u);
}

}  // namespace
}  // namespace onemap::mapping
