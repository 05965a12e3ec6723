// What is refused, and how it is said.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/team_robots.hpp"

namespace onemap::mapping {
namespace {

using namespace std::chrono_literals;
using test::Author;
using test::first;
using test::kNow;
using test::listener;
using test::Robot;
using test::second;
using test::whole_team;

TEST(TeamRefusals, MalformedRecordsAreCountedAndLoseNothingElse) {
  const auto number = [](RecordKind kind) { return static_cast<std::uint16_t>(kind); };
  Author odd("robot2");
  for (const RecordPtr& record : second().written()) {
    const auto lane = static_cast<Lane>(record->id.log.lane);
    auto body = record->body;
    if (record->kind == number(RecordKind::finished)) {
      auto finished = decode_finished(body).value();
      odd.write(Lane::features, number(RecordKind::keyframe), {1, 2, 3});
      odd.write(Lane::voxels, number(RecordKind::submap), std::vector<std::uint8_t>(40, 7));
      odd.write(Lane::poses, number(RecordKind::link), {0});
      odd.write(Lane::poses, number(RecordKind::solution), {9, 9});
      odd.write(Lane::poses, 999, {1});
      ++finished.keyframes;
      ++finished.submaps;
      body = encode(finished);
    }
    odd.write(lane, record->kind, body);
  }
  Robot plain(listener()), robot(listener());
  plain.apply(whole_team({&first(), &second()}));
  robot.apply(whole_team({&first(), &odd}));
  plain.work();
  robot.work();
  ASSERT_TRUE(plain.view().settled);
  EXPECT_TRUE(robot.view().settled);
  EXPECT_EQ(robot.view().digest, plain.view().digest);
  EXPECT_TRUE(plain.map().refused().empty());
  const auto& refused = robot.map().refused();
  EXPECT_EQ(refused.size(), 5u);
  for (const auto& [kind, what] : refused) EXPECT_EQ(what.count, 1u) << kind << ": " << what.last_reason;
  EXPECT_THAT(refused.at(number(RecordKind::keyframe)).last_reason, testing::HasSubstr("keyframe"));
  EXPECT_THAT(refused.at(number(RecordKind::submap)).last_reason, testing::HasSubstr("voxel_um"));
  EXPECT_THAT(refused.at(999).last_reason, testing::HasSubstr("not known"));
}

TEST(TeamRefusals, AnEmptyMapIsNotSettledOnInSilence) {
  Author deep("a");
  deep.hello();
  const RecordPtr refused = deep.write(Lane::voxels, RecordKind::submap, SubmapRecord{0, 10000, 1'010'000, {}});
  deep.write(Lane::control, RecordKind::finished, FinishedRecord{1, 0, 0, 1});
  Robot robot(deep);
  robot.apply(deep.written());
  robot.work();
  EXPECT_TRUE(robot.view().settled);
  EXPECT_EQ(robot.view().blocks, 0u);
  EXPECT_EQ(robot.view().submaps_refused, 1u);
  const auto settled = robot.events<MapSettled>();
  ASSERT_EQ(settled.size(), 1u);
  EXPECT_EQ(settled[0].blocks, 0u);
  EXPECT_EQ(settled[0].submaps_refused, 1u);
  EXPECT_EQ(robot.events<RecordRefused>().at(0).id, refused->id);
}

TEST(TeamRefusals, AFullGlobalMapIsSaid) {
  Author wide("a");
  wide.hello();
  for (int i = 0; i < 2; ++i) wide.keyframe();
  for (int i = 0; i < 40; ++i) wide.submap({2 * i, 0, 0}, 9, i % 2);
  LinkRecord loops;
  loops.a = loops.b = wide.id();
  loops.incarnation_other = 1;
  loops.keyframes_a = loops.keyframes_b = 2;
  loops.reason = LinkReason::too_few_matches;
  wide.link(loops);
  wide.finish();
  TeamMapConfig config;
  config.atlas.map.budget_bytes = 200'000;
  TeamMap map(wide.id(), 1, config);
  for (const RecordPtr& record : wide.written()) map.apply(record, kNow);
  for (int i = 0; i < 9; ++i) {
    map.step(kNow);
    for (const TeamRecord& record : map.take_records())
      map.apply(wide.write(record.lane, static_cast<std::uint16_t>(record.kind), record.body), kNow);
    map.observe(kNow);
  }
  EXPECT_TRUE(map.view().settled);
  EXPECT_GT(map.view().blocks_refused, 0u);
  EXPECT_EQ(map.view().blocks, map.map()->capacity());
}

}  // namespace
}  // namespace onemap::mapping
