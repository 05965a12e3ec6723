// What a running daemon writes beside its map: recordings that play, and snapshots of the map.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hal/base/bytes.hpp"
#include "support/running.hpp"

namespace onemap {
namespace {

using namespace std::chrono_literals;
using test::Robot;
using test::TempFolder;
using testing::HasSubstr;
namespace fs = std::filesystem;

std::string settings(const TempFolder& folder, const std::string& toml) {
  folder.write("robot.toml", toml);
  return folder / "robot.toml";
}

// Messages by channel, as the statistics of a whole MCAP file (mcap.dev/spec) say; none: it is not whole.
std::vector<std::uint64_t> mcap_messages(const fs::path& file) {
  const std::string text = test::text_of(file);
  const std::string_view magic("\x89MCAP0\r\n");
  std::vector<std::uint64_t> messages;
  if (text.size() < 16 || !text.starts_with(magic) || !text.ends_with(magic)) return messages;
  ByteReader in({reinterpret_cast<const std::uint8_t*>(text.data()) + 8, text.size() - 16});
  while (in.remaining() > 0 && in.ok()) {
    constexpr std::uint8_t kStatistics = 0x0b;
    constexpr std::size_t kBeforeTheChannels = 42;
    const auto op = in.get<std::uint8_t>();
    const auto content = in.bytes(in.get<std::uint64_t>());
    if (op != kStatistics) continue;
    ByteReader statistics(content);
    (void)statistics.bytes(kBeforeTheChannels);
    for (auto left = statistics.get<std::uint32_t>(); left > 0 && statistics.ok(); left -= 10) {
      (void)statistics.get<std::uint16_t>();
      messages.push_back(statistics.get<std::uint64_t>());
    }
  }
  return messages;
}

TEST(Outputs, ARecordedWalkIsMappedAgainAsItWas) {
  const TempFolder folder;
  const auto config = settings(folder, "[record]\nstart = true\nleast_free_mb = 1\nformats = [\"tum\", \"mcap\"]\n");
  const std::vector<std::string> fast{"--once", "--speed", "max"};
  auto recorded = fast;
  recorded.insert(recorded.end(), {"--config", config});
  Robot first(folder, "first", "simulated:living-room?frames=60&seed=4", recorded, "robot");
  ASSERT_EQ(first.ends(300s), 0) << first.log();
  const std::string recording = first.out() / "recordings/0001";
  EXPECT_THAT(first.log(), HasSubstr("recorded 60 frames"));
  const auto messages = mcap_messages(recording + "/recording.mcap");  // image, points, tf, pose/odom, pose/map
  ASSERT_EQ(messages.size(), 5u) << "of the same walk, to look at";
  EXPECT_EQ(messages[0], 60u);
  EXPECT_EQ(messages[1], 6u) << "a cloud with every tenth picture";
  EXPECT_GT(messages[3], 50u) << "a pose a frame that was placed";
  Robot again(folder, "again", "replay:" + recording, fast, "robot");
  ASSERT_EQ(again.ends(300s), 0) << again.log();
  EXPECT_GT(test::lines(first.out() / "trajectory.txt"), 50u);
  EXPECT_EQ(test::text_of(again.out() / "trajectory.txt"), test::text_of(first.out() / "trajectory.txt"));
  EXPECT_EQ(again.status("map_digest", std::string("none")), first.status("map_digest", std::string()));
}

TEST(Outputs, WhatAKilledDaemonRecordedPlays) {
  const TempFolder folder;
  const auto config = settings(folder, "[record]\nstart = true\nleast_free_mb = 1\n");
  Robot killed(folder, "killed", "simulated:living-room?width=320&height=240&frames=100000&seed=4",
               {"--config", config});
  const fs::path recording = killed.out() / "recordings/0001";
  ASSERT_TRUE(test::wait_until([&] { return test::lines(recording / "rgb.txt") > 30; }, 60s)) << killed.log();
  killed.process().kill();
  Robot again(folder, "again", "replay:" + recording.string(), {"--once", "--speed", "max"});
  EXPECT_EQ(again.ends(300s), 0) << again.log();
  EXPECT_GT(test::lines(again.out() / "trajectory.txt"), 20u);
}

TEST(Outputs, SnapshotsFollowTheMapWhileARobotWorks) {
  const TempFolder folder;
  const auto config = settings(folder,
                               "[run]\nmerge_while_mapping_s = 1\n[snapshots]\non_change = true\nviews = [\"top\"]\n"
                               "keep = 2\n");
  Robot robot(folder, "robot", "simulated:house?width=320&height=240&frames=100000&seed=4", {"--config", config});
  const fs::path latest = robot.out() / "snapshots/latest";
  ASSERT_TRUE(test::wait_until([&] { return fs::exists(latest / "local.glb"); }, 120s)) << robot.log();
  EXPECT_TRUE(fs::exists(latest / "local_top.png"));
  EXPECT_THAT(robot.log(), HasSubstr("snapshot in "));
  ASSERT_TRUE(test::wait_until([&] { return fs::exists(robot.out() / "snapshots/000003"); }, 240s)) << robot.log();
  EXPECT_FALSE(fs::exists(robot.out() / "snapshots/000001"));
  EXPECT_EQ(robot.stop(), 0) << robot.log();
}

TEST(Outputs, ByTheClockARunningDaemonDrawsFromBehindItAndRewritesItsFloorPlan) {
  const TempFolder folder;
  const auto config = settings(folder,
                               "[run]\nmerge_while_mapping_s = 1\n[snapshots]\nevery_s = 2\nviews = [\"follow\"]\n"
                               "kinds = [\"png\", \"plan\"]\n");
  Robot robot(folder, "robot", "simulated:house?width=320&height=240&frames=100000&seed=4", {"--config", config});
  const fs::path plan = robot.out() / "map.pgm";
  ASSERT_TRUE(test::wait_until([&] { return fs::exists(robot.out() / "map.yaml"); }, 240s)) << "the last of a plan";
  const std::string first = test::text_of(plan);
  EXPECT_THAT(first, testing::StartsWith("P5"));
  EXPECT_TRUE(test::wait_until([&] { return test::text_of(plan) != first; }, 240s)) << robot.log();
  // A snapshot that was begun before there was a map has no plan.
  const fs::path latest = robot.out() / "snapshots/latest";
  EXPECT_TRUE(test::wait_until([&] { return fs::exists(latest / "map.pgm"); }, 120s)) << robot.log();
  EXPECT_TRUE(test::wait_until([&] { return fs::exists(latest / "local_follow.png"); }, 120s)) << robot.log();
  EXPECT_EQ(robot.stop(), 0) << robot.log();
}

// Nobody asked: whoever drives by the plan has it, and nothing else is drawn.
TEST(Outputs, TheFloorPlanIsThereWhileARobotWorks) {
  const TempFolder folder;
  for (const bool refresh : {true, false}) {
    const std::string off = refresh ? "" : "[map]\nrefresh_plan = false\n";
    const auto config = settings(folder, "[run]\nmerge_while_mapping_s = 1\n" + off);
    Robot robot(folder, refresh ? "on" : "off", "simulated:house?width=320&height=240&frames=100000&seed=4",
                {"--config", config});
    ASSERT_TRUE(test::wait_until([&] { return fs::exists(robot.out() / "settled-map"); }, 240s)) << robot.log();
    if (refresh) {
      EXPECT_TRUE(test::wait_until([&] { return fs::exists(robot.out() / "map.yaml"); }, 240s)) << robot.log();
      EXPECT_THAT(test::text_of(robot.out() / "map.pgm"), testing::StartsWith("P5\n# onemap"));
    }
    EXPECT_FALSE(fs::exists(robot.out() / "snapshots"));
    robot.process().kill();
    EXPECT_EQ(fs::exists(robot.out() / "map.yaml"), refresh);
  }
}

}  // namespace
}  // namespace onemap
