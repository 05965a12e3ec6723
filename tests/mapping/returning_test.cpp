// A robot that walks round and round a house: what it keeps grows with the house and not with the time.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <deque>
#include <map>
#include <set>

#include "mapping/local/local_mapper.hpp"
#include "mapping/team/team_map.hpp"
#include "support/stream.hpp"
#include "support/team_author.hpp"

namespace onemap::mapping {
namespace {

using namespace std::chrono_literals;

// Alone, with its own team map; voxel records name what they make needless, and what remains of keyframes takes their
// places, as the daemon has them do.
struct Returning {
  void write(Lane lane, RecordKind kind, std::vector<std::uint8_t> body) {
    if (kind == RecordKind::submap && !needless.empty()) {
      author.replacing(needless.front().seq);
      needless.pop_front();
    }
    team.apply(author.write(lane, static_cast<std::uint16_t>(kind), std::move(body)), now);
  }
  void see(const hal::FrameView& frame) {
    mapper.process(frame);
    now += 100ms;
    KeyframeRecord keyframe;
    while (mapper.take_keyframe(keyframe)) write(Lane::features, RecordKind::keyframe, encode(keyframe));
    SubmapRecord submap;
    while (mapper.take_submap(submap)) write(Lane::voxels, RecordKind::submap, encode(submap));
  }
  void work() {
    for (bool busy = true; busy;) {
      busy = team.step(now);
      team.observe(now);
      for (TeamRecord& record : team.take_records()) write(record.lane, record.kind, std::move(record.body));
    }
    const SpareRecords spare = team.take_spare();
    needless.insert(needless.end(), spare.needless.begin(), spare.needless.end());
    unread.insert(spare.unread.begin(), spare.unread.end());
    for (const KeyframeRemains& remains : spare.keyframes) {
      author.replacing(remains.of.seq);
      write(Lane::features, RecordKind::keyframe, remains.body);
    }
  }

  explicit Returning(const hal::Intrinsics& k) : mapper({}, k) {}
  static TeamMapConfig config() {
    TeamMapConfig out;
    out.merge_while_mapping = 10s;
    out.map_interval = 10s;
    return out;
  }
  LocalMapper mapper;
  test::Author author{"a"};
  Instant now{1000s};
  TeamMap team{author.id(), 1, config()};
  std::deque<RecordId> needless;
  std::set<RecordId> unread;
};

std::pair<std::uint64_t, std::size_t> fused(const TeamLog& log, const SolutionRecord& solution) {
  MapFusion fusion(128u << 20);
  fusion.aim(log, {solution, everything_here(log, solution)});
  while (fusion.underway()) EXPECT_TRUE(fusion.step([] { return false; }));
  return {fusion.digest(), fusion.map()->used()};
}

TEST(Returning, WhatIsKeptGrowsWithThePlaceAndNotWithTheTime) {
  test::Stream stream("simulated:house?frames=1400&fps=10&width=320&height=240");
  Returning robot(stream.intrinsics());
  robot.author.hello();
  robot.team.apply(robot.author.written().back(), robot.now);
  std::size_t n = 0;
  while (const auto frame = stream.next()) {
    robot.see(frame->view());
    if (++n % 100 == 0) robot.work();
  }
  ASSERT_NE(robot.team.solution(), nullptr);
  const SolutionRecord solution = *robot.team.solution();

  struct LaneBytes {
    std::size_t written = 0, kept = 0;
  };
  std::map<std::uint8_t, LaneBytes> lanes;
  TeamLog whole(RobotId::from_name("b"), 1), late(RobotId::from_name("c"), 1), everything(RobotId::from_name("d"), 1);
  for (const RecordPtr& record : robot.author.written()) {
    const bool gone = robot.unread.contains(record->id);
    LaneBytes& bytes = lanes[record->id.log.lane];
    bytes.written += record->body.size();
    bytes.kept += gone ? 0 : record->body.size();
    Record as_if_none_were_named = *record;
    as_if_none_were_named.seal.replaces = kNoSequence;
    ASSERT_TRUE(whole.apply(record, {}).ok());
    ASSERT_TRUE(late.apply(gone ? test::without_body(record) : record, {}).ok());
    ASSERT_TRUE(everything.apply(std::make_shared<const Record>(as_if_none_were_named), {}).ok());
  }
  const auto of_whole = fused(whole, solution), of_late = fused(late, solution), of_all = fused(everything, solution);
  const LaneBytes voxels = lanes[static_cast<std::uint8_t>(Lane::voxels)],
                  keyframes = lanes[static_cast<std::uint8_t>(Lane::features)];
  fmt::print("{} of {} kB of voxels kept, {} of {} kB of keyframes; {} records let go; {} blocks of {}\n",
             voxels.kept / 1000, voxels.written / 1000, keyframes.kept / 1000, keyframes.written / 1000,
             robot.unread.size(), of_whole.second, of_all.second);
  EXPECT_LT(voxels.kept, 3 * voxels.written / 4);
  EXPECT_LT(keyframes.kept, 3 * keyframes.written / 4);
  EXPECT_EQ(of_whole, of_late) << "whoever still has the bodies";
  EXPECT_GT(of_whole.second, of_all.second * 95 / 100) << "nothing of the house is lost";
}

}  // namespace
}  // namespace onemap::mapping
