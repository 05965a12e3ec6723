// Voxels that are read again when they are wanted.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mapping/team/needless_submaps.hpp"
#include "support/team_robots.hpp"

namespace onemap::mapping {
namespace {

using namespace std::chrono_literals;
using test::Author;
using test::first;
using test::second;

// Where bodies are kept; some may be unreadable for a while.
struct Shelf {
  std::map<RecordId, RecordPtr> records;
  std::set<RecordId> unreadable;
  std::size_t reads = 0;
  ReadRecord read = [this](const RecordId& id) -> RecordPtr {
    ++reads;
    return unreadable.contains(id) ? nullptr : records.at(id);
  };
  void keep(const Author& author) {
    for (const RecordPtr& record : author.written()) records[record->id] = record;
  }
};

SolutionRecord solution_of(const Author& author, std::int32_t aside = 0) {
  SolutionRecord out;
  out.reference = author.chain();
  out.robots.push_back({author.chain(), {}});
  for (std::uint32_t i = 0; i < 3; ++i) {
    out.robots[0].anchors.push_back({i, test::two_metres_each(i)});
    out.robots[0].anchors.back().T_map_anchor.t_10um[1] = aside;
  }
  return out;
}

// The map of one robot of three submaps, from where its bodies are read.
struct BodiesElsewhere : testing::Test {
  Author robot = test::small_robot("a");
  Shelf shelf;
  TeamLog log{RobotId::from_name("self"), 1, true};
  MapFusion fusion{4u << 20, shelf.read};
  RecordPtr last;

  BodiesElsewhere() {
    robot.submap({0, 1, 0}, 50, 1);
    last = robot.submap({0, 2, 0}, 60, 2);
    shelf.keep(robot);
    for (const RecordPtr& record : robot.written()) EXPECT_TRUE(log.apply(record, Instant{}).ok());
  }
  MapTarget target(const SolutionRecord& solution) const { return {solution, everything_here(log, solution)}; }
  void fuse(const SolutionRecord& solution) {
    fusion.aim(log, target(solution));
    while (fusion.underway()) ASSERT_TRUE(fusion.step([] { return false; }));
  }
  std::uint64_t held_in_memory(const SolutionRecord& solution) const {
    TeamLog held(RobotId::from_name("self"), 1);
    for (const RecordPtr& record : robot.written()) EXPECT_TRUE(held.apply(record, Instant{}).ok());
    MapFusion other(4u << 20);
    other.aim(held, {solution, everything_here(held, solution)});
    while (other.underway()) EXPECT_TRUE(other.step([] { return false; }));
    return other.digest();
  }
};

TEST_F(BodiesElsewhere, AreNotHeldAndMakeTheSameMap) {
  fuse(solution_of(robot));
  EXPECT_EQ(fusion.digest(), held_in_memory(solution_of(robot)));
  EXPECT_EQ(shelf.reads, 3u);
  for (const std::size_t position : {0u, 2u}) {
    const SubmapPlace* place = log.find(robot.chain())->submaps.find(position);
    ASSERT_NE(place, nullptr);
    EXPECT_TRUE(place->record->body.empty());
  }
  fuse(solution_of(robot, 3000));
  EXPECT_EQ(fusion.digest(), held_in_memory(solution_of(robot, 3000)));
  EXPECT_EQ(shelf.reads, 9u) << "what was there is taken back, so it is read as well";
}

TEST_F(BodiesElsewhere, WhatCannotBeReadStaysInTheMapAsItWas) {
  fuse(solution_of(robot));
  const std::uint64_t before = fusion.map()->digest();
  for (const auto& [id, record] : shelf.records) shelf.unreadable.insert(id);
  fuse(solution_of(robot, 3000));
  ASSERT_TRUE(fusion.done());
  EXPECT_EQ(fusion.submaps_unread(), 3u);
  EXPECT_EQ(fusion.digest(), 0u) << "it is nobody's map";
  EXPECT_EQ(fusion.map()->digest(), before);
  EXPECT_FALSE(fusion.at(target(solution_of(robot, 3000))));
  const auto bad = fusion.take_malformed();
  ASSERT_FALSE(bad.empty());
  EXPECT_THAT(bad[0].reason, testing::HasSubstr("cannot be read"));

  shelf.unreadable = {last->id};
  fuse(solution_of(robot, 3000));
  EXPECT_EQ(fusion.submaps_unread(), 1u);
  shelf.unreadable.clear();
  fuse(solution_of(robot, 3000));
  EXPECT_TRUE(fusion.at(target(solution_of(robot, 3000))));
  EXPECT_EQ(fusion.digest(), held_in_memory(solution_of(robot, 3000)));
}

TEST_F(BodiesElsewhere, WhatNeverCouldBeReadComesWhenItCan) {
  shelf.unreadable = {last->id};
  fuse(solution_of(robot));
  EXPECT_EQ(fusion.digest(), 0u);
  EXPECT_GT(fusion.map()->used(), 0u) << "the others are there";
  shelf.unreadable.clear();
  fuse(solution_of(robot));
  EXPECT_EQ(fusion.digest(), held_in_memory(solution_of(robot)));
}

TEST_F(BodiesElsewhere, ARecordThatCannotBeReadIsNotFoundNeedless) {
  robot.submap({0, 2, 0}, 60, 2);  // the same block again
  shelf.keep(robot);
  EXPECT_TRUE(log.apply(robot.written().back(), Instant{}).ok());
  NeedlessSubmaps blind(shelf.read), seeing(shelf.read);
  const SolvedRobot solved = solution_of(robot).robots[0];
  shelf.unreadable = {robot.written().back()->id};
  EXPECT_THAT(blind.look(*log.find(robot.chain()), solved), testing::IsEmpty());
  shelf.unreadable.clear();
  EXPECT_THAT(seeing.look(*log.find(robot.chain()), solved), testing::ElementsAre(last->id.seq));
}

// A robot alone, that goes on.
TEST(TeamMapElsewhere, WhatIsStillInTheMapIsNotLetGo) {
  Author robot = test::small_robot("a");
  Shelf shelf;
  TeamMapConfig config;
  config.atlas = test::small_map();
  config.merge_while_mapping = config.map_interval = 1s;
  config.read_again = shelf.read;
  TeamMap map(robot.id(), 1, config);
  Instant now{1000s};
  std::size_t applied = 0;
  const auto work = [&] {
    shelf.keep(robot);
    for (int i = 0; i < 20; ++i) {
      for (now += 1s; applied < robot.written().size(); ++applied) map.apply(robot.written()[applied], now);
      while (map.step(now)) map.observe(now);
      map.observe(now);
      for (const TeamRecord& record : map.take_records()) {
        const RecordPtr written = robot.write(record.lane, static_cast<std::uint16_t>(record.kind), record.body);
        shelf.records[written->id] = written;
      }
    }
  };
  work();
  ASSERT_NE(map.view().digest, 0u);
  const auto is_submap = [](const RecordPtr& r) { return r->kind == static_cast<std::uint16_t>(RecordKind::submap); };
  const RecordPtr first_one = *std::ranges::find_if(robot.written(), is_submap);
  robot.replacing(first_one->id.seq).submap({0, 3, 0});
  shelf.unreadable = {first_one->id};
  work();
  EXPECT_EQ(map.view().submaps_unread, 1u);
  EXPECT_THAT(map.take_spare().unread, testing::IsEmpty()) << "or it could never be taken back";
  shelf.unreadable.clear();
  work();
  EXPECT_NE(map.view().digest, 0u);
  EXPECT_THAT(map.take_spare().unread, testing::ElementsAre(first_one->id));
}

// The whole team's work with them: nothing is held but what the shelf has, and an unreadable one is told once.
TEST(TeamMapElsewhere, IsTheSameMap) {
  Shelf shelf;
  shelf.keep(first());
  shelf.keep(second());
  test::Robot plain(test::listener());
  plain.apply(test::whole_team({&first(), &second()}));
  plain.work();
  ASSERT_TRUE(plain.view().settled);

  const RecordPtr one = *std::ranges::find_if(second().written(), [](const RecordPtr& record) {
    return record->kind == static_cast<std::uint16_t>(RecordKind::submap);
  });
  shelf.unreadable = {one->id};
  TeamMapConfig config;
  config.atlas = test::small_map();
  config.read_again = shelf.read;
  test::Robot robot(test::listener(), config);
  robot.apply(test::whole_team({&first(), &second()}));
  robot.work();
  EXPECT_FALSE(robot.view().settled);
  EXPECT_EQ(robot.view().digest, 0u);
  EXPECT_EQ(robot.view().submaps_unread, 1u);
  ASSERT_EQ(robot.events<RecordRefused>().size(), 1u);
  EXPECT_EQ(robot.events<RecordRefused>()[0].id, one->id);
  shelf.unreadable.clear();
  robot.work(test::kNow + 1s);
  EXPECT_TRUE(robot.view().settled);
  EXPECT_EQ(robot.view().digest, plain.view().digest);
  EXPECT_EQ(robot.view().submaps_unread, 0u);
}

}  // namespace
}  // namespace onemap::mapping
