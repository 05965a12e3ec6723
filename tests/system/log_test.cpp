// Real daemons with their logs on the disk: what was told outlives kill -9, and comes back to who lost it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <csignal>
#include <deque>

#include "comms/disk/disk_store.hpp"
#include "comms/disk/posix_disk.hpp"
#include "comms/record_head.hpp"
#include "support/running.hpp"

namespace onemap {
namespace {

using namespace std::chrono_literals;
using test::Robot;

// The log of a robot that does not run.
struct Kept {
  std::unique_ptr<comms::PosixDisk> disk;
  std::unique_ptr<comms::DiskStore> log;
  explicit Kept(const Robot& robot) {
    auto opened = comms::PosixDisk::open((robot.out() / "log").string());
    if (!opened) throw std::runtime_error(opened.error().text());
    disk = std::move(*opened);
    auto store = comms::DiskStore::open(*disk, {});
    if (!store) throw std::runtime_error(store.error().text());
    log = std::move(*store);
  }
  std::uint32_t count(const LogId& id) const {
    const auto at = log->frontier().find(id);
    return at == log->frontier().end() ? 0 : at->second;
  }
};

struct Two : testing::Test {
  const test::TempFolder folder;
  const std::uint16_t ports[2] = {test::free_port(), test::free_port()};
  std::deque<Robot> robots;

  void SetUp() override { folder.write("keep.toml", "[store]\nkeep = true\n"); }
  Robot& start(std::size_t i) {
    return robots.emplace_back(
        folder, std::string(1, static_cast<char>('a' + i)),
        fmt::format("simulated:living-room?robot={}&robots=5&frames=100000&seed=3&width=320&height=240", i + 1),
        std::vector<std::string>{"--listen", fmt::format("127.0.0.1:{}", ports[i]), "--peer",
                                 fmt::format("127.0.0.1:{}", ports[1 - i]), "--config", folder / "keep.toml"});
  }
  static void kill_now(Robot& robot) {
    kill(robot.process().pid(), SIGKILL);
    ASSERT_TRUE(robot.process().wait(20s));
  }
  static bool has_records_of(const Robot& robot, const char* of, std::size_t more_than) {
    const auto status = robot.status();
    if (!status.is_object()) return false;
    const auto in_map = status.value("keyframes_in_map", std::map<std::string, std::size_t>{});
    const auto at = in_map.find(of);
    return at != in_map.end() && at->second > more_than;
  }
};

// At any moment a's own disk holds all that b has of a, record for record: no place of a log was filled twice.
TEST_F(Two, WhatWasToldOutlivesKills) {
  std::uint64_t compared = 0;
  for (int round = 0; round < 3; ++round) {
    Robot &a = start(0), &b = start(1);
    ASSERT_TRUE(b.says("neighbour a at", 60s)) << b.log();
    ASSERT_TRUE(test::wait_until([&] { return b.status("keyframes", 0) > 0 && a.status("keyframes", 0) > 1; }, 90s))
        << a.log();
    std::this_thread::sleep_for(std::chrono::milliseconds(200 + 370 * round));
    kill_now(a);
    kill_now(b);
    const Kept of_a(a), of_b(b);
    for (const auto& [log, count] : of_b.log->frontier()) {
      if (log.robot.name() != "a") continue;
      ASSERT_GE(of_a.count(log), count) << "a record that was told is gone";
      for (std::uint32_t seq = 0; seq < count; ++seq, ++compared) {
        const auto here = of_a.log->find({log, seq}), there = of_b.log->find({log, seq});
        ASSERT_TRUE(here != nullptr && there != nullptr);
        ASSERT_EQ(hash_of(comms::head_of(*here)), hash_of(comms::head_of(*there))) << "one place, two records";
      }
    }
  }
  EXPECT_GT(compared, 3u) << "b must have heard of a";
}

TEST_F(Two, AWipedLogComesBackFromTheNeighbour) {
  Robot &a = start(0), &b = start(1);
  ASSERT_TRUE(test::wait_until([&] { return a.status("keyframes", 0) > 1; }, 90s)) << a.log();
  ASSERT_TRUE(b.says("neighbour a at", 60s)) << b.log();
  std::this_thread::sleep_for(2s);
  kill_now(a);
  VersionVector before;
  {
    const Kept kept(a);
    for (const auto& [log, count] : kept.log->frontier())
      if (log.robot.name() == "a") before[log] = count;
  }
  ASSERT_FALSE(before.empty());
  std::filesystem::remove_all(a.out() / "log");
  Robot& again = start(0);
  ASSERT_TRUE(again.says("neighbour b at", 60s)) << again.log();
  std::this_thread::sleep_for(10s);
  kill_now(again);
  kill_now(b);
  const Kept mine(again), theirs(b);
  std::uint32_t back = 0;
  for (const auto& [log, count] : before) {
    EXPECT_EQ(mine.count(log), theirs.count(log)) << "lane " << int{log.lane};
    back += mine.count(log);
  }
  EXPECT_GT(back, 1u);
}

}  // namespace
}  // namespace onemap
