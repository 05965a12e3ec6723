// Real daemons with their logs on the disk: what was told outlives kill -9, and comes back to who lost it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <csignal>
#include <deque>
#include <fstream>

#include "comms/disk/disk_store.hpp"
#include "comms/disk/posix_disk.hpp"
#include "comms/record_head.hpp"
#include "support/running.hpp"

namespace onemap {
namespace {

using namespace std::chrono_literals;
using test::Robot;

// The log of a robot that does not run, or a copy of one that does.
struct Kept {
  std::unique_ptr<comms::PosixDisk> disk;
  std::unique_ptr<comms::DiskStore> log;
  explicit Kept(const Robot& robot) : Kept(robot.out() / "log") {}
  explicit Kept(const std::filesystem::path& folder) {
    auto opened = comms::PosixDisk::open(folder.string());
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

  Robot& start(std::size_t i) {
    return robots.emplace_back(
        folder, std::string(1, static_cast<char>('a' + i)),
        fmt::format("simulated:living-room?robot={}&robots=5&frames=100000&seed=3&width=320&height=240", i + 1),
        std::vector<std::string>{"--listen", fmt::format("127.0.0.1:{}", ports[i]), "--peer",
                                 fmt::format("127.0.0.1:{}", ports[1 - i])});
  }
  static void kill_now(Robot& robot) {
    kill(robot.process().pid(), SIGKILL);
    ASSERT_TRUE(robot.process().wait(20s));
  }
  // What is in its log, by files: keyframes are written when nothing moves them any more, long after they are made.
  static std::uintmax_t logged_bytes(const Robot& robot) {
    std::error_code none;
    std::uintmax_t sum = 0;
    for (const auto& file : std::filesystem::directory_iterator(robot.out() / "log", none))
      if (const auto bytes = file.file_size(none); !none) sum += bytes;
    return sum;
  }
  // What is in the log of a robot that runs: of a copy, whose end may be torn as after a kill.
  VersionVector frontier_now(const Robot& robot) const {
    const std::filesystem::path copy = folder / "looked-at";
    std::error_code none;
    std::filesystem::remove_all(copy, none);
    std::filesystem::copy(robot.out() / "log", copy, std::filesystem::copy_options::recursive, none);
    return none ? VersionVector{} : Kept(copy).log->frontier();
  }
  std::uint32_t records(const Robot& of, const std::string& author) const {
    std::uint32_t sum = 0;
    for (const auto& [log, count] : frontier_now(of)) sum += log.robot.name() == author ? count : 0;
    return sum;
  }
};

std::vector<std::filesystem::path> segments(const std::filesystem::path& log) {
  std::vector<std::filesystem::path> all;
  for (const auto& file : std::filesystem::directory_iterator(log))
    if (file.path().filename().string().starts_with("segment-")) all.push_back(file.path());
  std::ranges::sort(all);
  return all;
}

// At any moment a's own disk holds all that b has of a, record for record: no place of a log was filled twice.
TEST_F(Two, WhatWasToldOutlivesKills) {
  std::uint64_t compared = 0;
  for (int round = 0; round < 3; ++round) {
    Robot &a = start(0), &b = start(1);
    ASSERT_TRUE(b.says("neighbour a at", 60s)) << b.log();
    const auto before = logged_bytes(b);
    ASSERT_TRUE(test::wait_until([&] { return logged_bytes(b) > before + 400'000; }, 90s)) << a.log() << b.log();
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
  fmt::print("compared {} records\n", compared);
  EXPECT_GT(compared, 30u) << "b must have heard of a";
}

TEST_F(Two, AWipedLogComesBackFromTheNeighbour) {
  Robot &a = start(0), &b = start(1);
  ASSERT_TRUE(b.says("neighbour a at", 60s)) << b.log();
  ASSERT_TRUE(test::wait_until([&] { return records(b, "a") > 3; }, 90s)) << a.log() << b.log();
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
  const auto are_back = [&] {
    const auto mine = frontier_now(again), theirs = frontier_now(b);
    return std::ranges::all_of(before, [&](const auto& log) {
      return theirs.contains(log.first) ? mine.contains(log.first) && mine.at(log.first) == theirs.at(log.first) : true;
    });
  };
  EXPECT_TRUE(test::wait_until(are_back, 90s)) << again.log();
  kill_now(again);
  kill_now(b);
  const Kept mine(again), theirs(b);
  std::uint32_t back = 0;
  for (const auto& [log, count] : before) {
    EXPECT_EQ(mine.count(log), theirs.count(log)) << "lane " << int{log.lane};
    back += mine.count(log);
  }
  EXPECT_GT(back, 3u);
}

// A disk that forgot some of it: what cannot be read is said and set aside, the neighbour gives it back, and the robot
// maps on in the meantime.
TEST_F(Two, ADamagedLogIsSaidAndComesBackFromTheNeighbour) {
  Robot &a = start(0), &b = start(1);
  ASSERT_TRUE(b.says("neighbour a at", 60s)) << b.log();
  ASSERT_TRUE(test::wait_until([&] { return logged_bytes(b) > 600'000 && logged_bytes(a) > 600'000; }, 90s));
  kill_now(a);
  kill_now(b);
  const auto log = a.out() / "log";
  VersionVector before;
  {
    const Kept of_a(a), of_b(b);
    for (const auto& [id, count] : of_a.log->frontier())
      if (id.robot.name() == "a") before[id] = std::min(count, of_b.count(id));
  }
  ASSERT_FALSE(before.empty());
  const auto first = segments(log).front(), last = segments(log).back();
  std::fstream(first, std::ios::in | std::ios::out | std::ios::binary)
      .seekp(100'000)
      .write("spoilt, and not by one bit", 26);
  std::ofstream(last, std::ios::app | std::ios::binary) << std::string(3000, '\xee');
  const std::string foreign = "segment-000000ff";
  std::ofstream(log / foreign, std::ios::binary) << std::string(50'000, '\x5a');

  Robot& again = start(0);
  EXPECT_TRUE(again.says(foreign + " holds no record; set aside as " + foreign + ".corrupt-1", 30s)) << again.log();
  EXPECT_TRUE(again.says("stand behind a place that cannot be read; neighbours are asked for them", 5s)) << again.log();
  EXPECT_TRUE(test::wait_until([&] { return again.status("keyframes", 0) > 1; }, 90s)) << again.log();
  Robot& other = start(1);
  ASSERT_TRUE(again.says("neighbour b at", 60s)) << again.log();
  std::this_thread::sleep_for(10s);
  kill_now(again);
  kill_now(other);
  const Kept mine(again);
  for (const auto& [id, count] : before) EXPECT_GE(mine.count(id), count) << "lane " << int{id.lane};
}

// The log holds the map of the whole team, and who is given a copy goes on in it.
TEST_F(Two, ACopiedLogIsAMapThatAnotherRobotGoesOnIn) {
  folder.write("alone.toml", "[run]\nlost_after_s = 2\nmerge_while_mapping_s = 1\n");
  const auto alone = [&](const std::string& name, int robot) -> Robot& {
    return robots.emplace_back(
        folder, name,
        fmt::format("simulated:living-room?robot={}&robots=5&frames=100000&seed=3&width=320&height=240", robot),
        std::vector<std::string>{"--config", folder / "alone.toml"});
  };
  Robot& first = alone("first", 1);
  ASSERT_TRUE(test::wait_until([&] { return first.status("keyframes", 0) > 30; }, 120s)) << first.log();
  EXPECT_EQ(first.stop(), 0);
  std::filesystem::create_directories(folder / "second");
  std::filesystem::copy(first.out() / "log", folder / "second/log", std::filesystem::copy_options::recursive);
  Robot& second = alone("second", 2);
  ASSERT_TRUE(second.says("records of earlier lives and of the team are in", 30s)) << second.log();
  EXPECT_TRUE(second.says("link first - second accepted", 120s)) << second.log();
  const auto has_both = [&] { return second.status("robots_in_map", 0) == 2; };
  EXPECT_TRUE(test::wait_until(has_both, 120s)) << second.log();
  EXPECT_EQ(second.stop(), 0) << second.log();
}

// The same while both run: save and load.
TEST_F(Two, ASavedMapIsLoadedByARobotThatRuns) {
  const auto alone = [&](const std::string& name, int robot) -> Robot& {
    folder.write(name + ".toml", "[run]\nlost_after_s = 2\nmerge_while_mapping_s = 1\n[control]\nsocket = \"" +
                                     (folder / (name + ".sock")) + "\"\n");
    return robots.emplace_back(
        folder, name,
        fmt::format("simulated:living-room?robot={}&robots=5&frames=100000&seed=3&width=320&height=240", robot),
        std::vector<std::string>{"--config", folder / (name + ".toml")});
  };
  const auto ctl = [&](const std::string& name, const std::string& command, const std::string& path) {
    const int status =
        test::run("onemapctl", {"--socket", folder / (name + ".sock"), "--json", "--timeout", "60", command, path},
                  folder / "said");
    const std::string said = test::text_of(folder / "said");
    EXPECT_EQ(status, 0) << said;
    return nlohmann::json::parse(said, nullptr, false);
  };
  Robot& first = alone("first", 1);
  ASSERT_TRUE(test::wait_until([&] { return first.status("keyframes", 0) > 30; }, 120s)) << first.log();
  const auto saved = ctl("first", "save", "house.log");
  EXPECT_EQ(first.stop(), 0);
  Robot& second = alone("second", 2);
  ASSERT_TRUE(test::wait_until([&] { return second.status("keyframes", 0) > 1; }, 90s)) << second.log();
  std::filesystem::copy(first.out() / "house.log", second.out() / "house.log",
                        std::filesystem::copy_options::recursive);
  const auto loaded = ctl("second", "load", "house.log");
  EXPECT_GT(loaded.value("taken", 0), 30) << loaded.dump();
  EXPECT_EQ(loaded.value("taken", 0), saved.value("records", -1)) << loaded.dump();
  EXPECT_TRUE(loaded.value("logs_refused", nlohmann::json()).empty()) << loaded.dump();
  EXPECT_TRUE(second.says("link first - second accepted", 120s)) << second.log();
  EXPECT_TRUE(test::wait_until([&] { return second.status("robots_in_map", 0) == 2; }, 120s)) << second.log();
  EXPECT_EQ(ctl("second", "load", "house.log").value("taken", -1), 0) << "they are here";
  EXPECT_EQ(second.stop(), 0) << second.log();
}

}  // namespace
}  // namespace onemap
