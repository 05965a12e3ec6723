// The team's map as a function of records.
#include "mapping/team/team_map.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/team_robots.hpp"

namespace onemap::mapping {
namespace {

using namespace std::chrono_literals;
using test::Author;
using test::first;
using test::kNow;
using test::links_of;
using test::listener;
using test::Records;
using test::Robot;
using test::second;
using test::shuffled;
using test::stranger;
using test::whole_team;

TEST(TeamMap, OrderOfArrivalDoesNotMatter) {
  const Records all = whole_team({&first(), &second(), &stranger()});
  Robot in_order(listener());
  in_order.apply(all);
  EXPECT_TRUE(in_order.work().empty());
  ASSERT_TRUE(in_order.view().settled);
  ASSERT_NE(in_order.view().digest, 0u);
  EXPECT_EQ(in_order.map().links().size(), 3u);
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Robot robot(listener());
    for (const RecordPtr& record : shuffled(all, seed)) {
      robot.apply(record);
      if (seed % 2 == 0) robot.work();  // whether it works in between or only at the end
    }
    robot.work();
    EXPECT_TRUE(robot.view().settled);
    EXPECT_EQ(robot.view().digest, in_order.view().digest);
    EXPECT_EQ(links_of(robot), links_of(in_order));
  }
}

TEST(TeamMap, ARobotWithoutLinksStaysOutAndIsStillListed) {
  Robot robot(listener());
  robot.apply(whole_team({&first(), &second(), &stranger()}));
  robot.work();
  EXPECT_EQ(robot.view().robots_known, 3u);
  EXPECT_EQ(robot.view().robots_finished, 3u);
  EXPECT_EQ(robot.view().robots_in_map, 2u);
  EXPECT_EQ(robot.map().members().at(stranger().chain()).name, "robot3");
  EXPECT_FALSE(robot.map().members().at(stranger().chain()).trajectory.size() == 0);
  const SolutionRecord* solution = robot.map().solution();
  ASSERT_NE(solution, nullptr);
  for (const auto& solved : solution->robots) EXPECT_NE(solved.chain, stranger().chain());
  for (const auto& link : robot.map().links())
    EXPECT_EQ(link.reason == LinkReason::accepted, link.b == second().id()) << link.b.name();
}

TEST(TeamMap, RobotsThatKnewDifferentPartsAgreeOnceTheyHoldTheSame) {
  const Records all = whole_team({&first(), &second(), &stranger()});
  Robot a(listener()), b(listener());
  Records left_for_a, left_for_b;
  std::set<LogId> cut_a, cut_b;  // a log is held up to a record
  for (std::size_t i = 0; i < all.size(); ++i) {
    const LogId& log = all[i]->id.log;
    if (i % 7 == 3) cut_a.insert(log);
    if (i % 5 == 2) cut_b.insert(log);
    cut_a.contains(log) ? left_for_a.push_back(all[i]) : a.apply(all[i]);
    cut_b.contains(log) ? left_for_b.push_back(all[i]) : b.apply(all[i]);
  }
  a.work();
  b.work();
  EXPECT_FALSE(a.view().settled);
  EXPECT_FALSE(b.view().settled);
  a.apply(left_for_a);
  b.apply(shuffled(left_for_b, 5));
  a.work();
  b.work();
  EXPECT_TRUE(a.view().settled);
  EXPECT_TRUE(b.view().settled);
  EXPECT_EQ(a.view().digest, b.view().digest);
  EXPECT_NE(a.view().digest, 0u);
}

TEST(TeamMap, AskedToStopItDoesNothingByHalves) {
  TeamMap map(first().id(), 1, {});
  for (const Author* author : {&first(), &second()})
    for (const RecordPtr& record : author->written()) map.apply(record, kNow);
  while (map.take_records().empty()) ASSERT_TRUE(map.step(kNow));  // its own loops come first
  int asked = 0;
  EXPECT_FALSE(map.step(kNow, [&] { return ++asked > 3; }));
  EXPECT_EQ(asked, 4);
  EXPECT_TRUE(map.take_records().empty());
  EXPECT_TRUE(map.step(kNow));  // and the pair is verified as if nothing had been
  const auto records = map.take_records();
  ASSERT_EQ(records.size(), 1u);
  EXPECT_EQ(records[0].kind, RecordKind::link);
}

TEST(TeamMap, MergesWhileRobotsMapAndEndsWithTheSameMap) {
  const Records all = whole_team({&first(), &second()});
  Robot expected(listener());
  expected.apply(all);
  expected.work();

  const auto finished = [](const RecordPtr& r) { return r->kind == static_cast<std::uint16_t>(RecordKind::finished); };
  Robot robot1(first(), 10s);
  Records last;
  for (const Author* author : {&first(), &second()})
    for (const RecordPtr& record : author->written()) finished(record) ? last.push_back(record) : robot1.apply(record);
  Instant now = kNow + 100s;
  EXPECT_FALSE(robot1.work(now).empty());
  EXPECT_EQ(robot1.view().robots_finished, 0u);
  EXPECT_EQ(robot1.view().robots_in_map, 2u);
  EXPECT_NE(robot1.view().digest, 0u);
  EXPECT_FALSE(robot1.view().settled);
  EXPECT_TRUE(robot1.work(now + 60s).empty()) << "nothing new, nothing done";
  robot1.apply(last);
  robot1.work(now);
  EXPECT_TRUE(robot1.view().settled);
  EXPECT_EQ(robot1.view().digest, expected.view().digest);
}

Records without_its_end(const Author& author) {
  Records out = author.written();
  std::erase_if(out, [](const RecordPtr& r) { return r->kind == static_cast<std::uint16_t>(RecordKind::finished); });
  return out;
}

// It is no record while robots map, and still known to who looked.
TEST(TeamMap, ARefusalWhileRobotsMapIsAnEventAndAnAnswerToWhy) {
  Robot robot(first(), 10s);
  robot.apply(without_its_end(first()));
  robot.apply(without_its_end(stranger()));
  robot.work(kNow + 100s);
  EXPECT_TRUE(robot.map().links().empty());
  std::vector<LinkLooked> looks;
  for (const LinkLooked& look : robot.events<LinkLooked>())
    if (look.link.a != look.link.b) looks.push_back(look);
  ASSERT_EQ(looks.size(), 1u);
  EXPECT_NE(looks[0].link.reason, LinkReason::accepted);
  EXPECT_FALSE(looks[0].again);
  const auto why = robot.map().why(stranger().id(), first().id());
  ASSERT_TRUE(why.ok());
  ASSERT_EQ(why->pairs.size(), 1u);
  ASSERT_TRUE(why->pairs[0].link.has_value());
  EXPECT_EQ(why->pairs[0].link->reason, looks[0].link.reason);
  EXPECT_FALSE(why->one_map);
}

// The lower robot lives and does not look: after a while the other one does.
TEST(TeamMap, APairThatIsNotLookedAtIsLookedAtByTheOther) {
  Author idle = test::small_robot("a"), mine = test::small_robot("b");
  idle.finish();
  mine.finish();
  Robot robot(mine);
  robot.apply(mine.written());
  robot.apply(idle.written());
  robot.work(kNow);
  EXPECT_TRUE(robot.map().links().empty());
  ASSERT_EQ(robot.view().waiting.size(), 1u);
  EXPECT_EQ(robot.view().waiting[0].what, Waiting::What::link);
  EXPECT_TRUE(robot.work(kNow + 60s).empty());
  const Records published = robot.work(kNow + 61s);
  ASSERT_FALSE(published.empty());
  EXPECT_EQ(published[0]->kind, static_cast<std::uint16_t>(RecordKind::link));
  ASSERT_EQ(robot.map().links().size(), 1u);
  EXPECT_EQ(robot.map().links()[0].a, idle.id());
}

}  // namespace
}  // namespace onemap::mapping
