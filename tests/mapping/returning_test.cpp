// A robot that walks round and round a house: what it keeps grows with the house and not with the time.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>

#include "support/returning_robot.hpp"
#include "support/stream.hpp"

namespace onemap::mapping {
namespace {

using test::fused;

TEST(Returning, WhatIsKeptGrowsWithThePlaceAndNotWithTheTime) {
  test::Stream stream("simulated:house?frames=1400&fps=10&width=320&height=240");
  test::ReturningRobot robot(stream.intrinsics());
  std::size_t n = 0, unthinned = 0;
  while (const auto frame = stream.next()) {
    robot.see(frame->view());
    if (++n % 100 == 0) robot.work();
    if (n == 1290) unthinned = robot.view().unthinned;
  }
  EXPECT_GT(unthinned, 10u) << "that have come since";
  EXPECT_EQ(robot.view().unthinned, 0u) << "all were looked at";
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
