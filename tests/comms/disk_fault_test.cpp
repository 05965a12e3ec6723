// The log on a disk that does not keep its word, and when the power goes.
#include "comms/disk/disk_store.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "memory_disk.hpp"
#include "passing_disk.hpp"
#include "sim_net.hpp"
#include "small_store.hpp"

namespace onemap::comms {
namespace {

using sim::MemoryDisk;
using sim::SignedLogs;
using test::body;
using test::expect_same;
using test::opened;
using test::small;

const RobotId kRobot = RobotId::from_name("robot"), kOther = RobotId::from_name("other");

// Full, read-only, failing, gone: a state with a word; poses go on, and all is written when the disk is back.
TEST(DiskStoreFaults, ADiskThatDoesNotWorkStopsVoxelsAndNotPoses) {
  for (const DiskFault fault : {DiskFault::no_space, DiskFault::read_only, DiskFault::failing, DiskFault::gone}) {
    MemoryDisk disk;
    DiskStoreConfig config = small();
    config.waiting_bytes = 100'000;
    SignedLogs logs;
    const LogId bulk{kRobot, 3, 1}, pose{kRobot, 1, 1};
    std::vector<Record> poses;
    {
      auto store = opened(disk, config);
      ASSERT_TRUE(store->append(logs.next(bulk, 1, body(1000))));
      ASSERT_TRUE(store->sync());
      disk.fault = fault;
      const auto refused = store->append(logs.record({bulk, 1}, 1, body(1000)));
      ASSERT_FALSE(refused);
      EXPECT_THAT(refused.error().text(), testing::HasSubstr(std::string(words(fault))));
      for (int k = 0; k < 50; ++k) {
        poses.push_back(logs.next(pose, 1, body(500)));
        ASSERT_TRUE(store->append(poses.back()));
      }
      EXPECT_FALSE(store->sync());
      EXPECT_EQ(store->durable(pose), 50u) << "told without a promise";
      EXPECT_EQ(store->durable(bulk), 1u);
      for (const Record& record : poses) expect_same(record, store->find(record.id));
      std::size_t more = 0;
      for (; store->append(logs.next(pose, 1, body(500))); ++more) ASSERT_LT(more, 1000u) << "memory is bounded";
      EXPECT_EQ(store->view().fault, fault);
      EXPECT_EQ(store->view().faults, 1u);
      EXPECT_EQ(store->view().refused_by_disk, 2u);
      disk.fault = DiskFault::none;
      EXPECT_TRUE(store->sync());
      EXPECT_EQ(store->durable(pose), 50u + more);
      EXPECT_TRUE(store->append(logs.record({bulk, 1}, 1, body(1000)))) << "it goes on by itself";
      EXPECT_EQ(store->view().fault, DiskFault::none);
    }
    auto store = opened(disk, config);
    for (const Record& record : poses) expect_same(record, store->find(record.id));
    EXPECT_EQ(store->frontier().at(bulk), 2u);
  }
}

// After an fsync that failed the next one says that all is well, and what was to be synced is gone.
TEST(DiskStoreFaults, WhatASyncDidNotKeepIsWrittenAgain) {
  MemoryDisk disk;
  SignedLogs logs;
  const LogId log{kRobot, 3, 1};
  std::vector<Record> written;
  {
    auto store = opened(disk);
    for (int k = 0; k < 5; ++k) {
      written.push_back(logs.next(log, 1, body(1000, static_cast<std::uint8_t>(k))));
      ASSERT_TRUE(store->append(written.back()));
      if (k == 2) disk.sync_fault = DiskFault::failing;
      (void)store->sync();
      if (k == 2) {
        EXPECT_EQ(store->durable(log), 2u) << "it must not be told";
        for (auto& [name, file] : disk.files()) file.bytes = file.synced;  // the pages are gone
      }
    }
    EXPECT_EQ(store->durable(log), 5u);
  }
  auto store = opened(disk);
  for (const Record& record : written) expect_same(record, store->find(record.id));
}

TEST(DiskStoreFaults, SetsAsideWhatIsNoLogAndGoesOn) {
  MemoryDisk disk;
  disk.put("segment-00000003", std::string(5000, 'x'));
  disk.put("segment-0000000g", "y");
  disk.put("notes.txt", "mine");
  auto store = opened(disk);
  ASSERT_NE(store, nullptr);
  const auto messages = store->view().messages;
  EXPECT_THAT(messages, testing::Contains(testing::HasSubstr(
                            "segment-00000003 holds no record; set aside as segment-00000003.corrupt-1")));
  EXPECT_THAT(messages, testing::Contains(testing::HasSubstr("notes.txt")));
  EXPECT_TRUE(disk.files().contains("segment-00000003.corrupt-1"));
  SignedLogs logs;
  ASSERT_TRUE(store->append(logs.next({kRobot, 0, 1}, 1, body(10))));
  store.reset();
  EXPECT_TRUE(disk.files().contains("segment-00000004")) << "no number is used twice";
  disk.fault = DiskFault::gone;
  EXPECT_FALSE(DiskStore::open(disk, small()).ok());
}

// A bit that flipped costs what lies there and what follows it in that log, which neighbours have; never more.
TEST(DiskStoreFaults, ASpoiltPlaceCostsOneLogItsEnd) {
  MemoryDisk disk;
  SignedLogs logs;
  const LogId a{kRobot, 3, 1}, b{kOther, 3, 1};
  std::vector<Record> written;
  {
    auto store = opened(disk);
    for (std::uint8_t k = 0; k < 40; ++k) {
      written.push_back(logs.next(k % 2 == 0 ? a : b, 1, body(10'000, k)));
      ASSERT_TRUE(store->append(written.back()));
    }
  }
  disk.files()["segment-00000001"].bytes[45'000] ^= 4;  // in the third record of a
  auto store = opened(disk);
  EXPECT_EQ(store->frontier().at(a), 2u);
  EXPECT_EQ(store->frontier().at(b), 20u);
  EXPECT_EQ(store->view().lost_records, 17u);
  EXPECT_THAT(store->view().messages, testing::Contains(testing::HasSubstr("neighbours are asked")));
  for (const Record& record : written)
    if (record.id.log == b || record.id.seq < 2) expect_same(record, store->find(record.id));
  for (const Record& record : written)
    if (record.id.log == a && record.id.seq >= 2) {
      ASSERT_TRUE(store->append(record)) << "they come again";
    }
  // And while it runs: a record that cannot be read back is not given out.
  for (auto& [name, file] : disk.files())
    for (std::size_t at = 300; at < file.bytes.size(); at += 5000) file.bytes[at] ^= 1;
  EXPECT_EQ(store->find(written[0].id), nullptr);
  EXPECT_GE(store->view().unreadable, 1u);
}

// Of two robots, in all lanes.
std::vector<Record> some_records(SignedLogs& logs) {
  test::Random random(5);
  std::vector<Record> records;
  for (std::size_t step = 0; step < 160; ++step) {
    const LogId log{step % 3 == 0 ? kOther : kRobot, static_cast<std::uint8_t>(random.below(5)), 1};
    records.push_back(logs.next(log, 1, body(random.below(3000), static_cast<std::uint8_t>(step))));
  }
  return records;
}

// The power goes at every point at which the disk changes, with everything torn that may be: what was durable is there
// as it was, and what else is there is whole.
TEST(DiskStoreFaults, NoPointOfACrashLosesWhatWasDurable) {
  SignedLogs logs;
  const std::vector<Record> records = some_records(logs);
  std::map<RecordId, Record> written;
  for (const Record& record : records) written.emplace(record.id, record);
  const Record next_life = logs.next({kRobot, 0, 2}, 1, body(10));
  std::size_t crashes = 0, torn = 0;
  for (std::size_t cut = 0;; ++cut) {
    MemoryDisk disk;
    disk.cut_power_at(cut, 1000 + cut);
    std::map<LogId, std::uint32_t> promised;
    bool crashed = false;
    DiskStoreConfig config = small(256u << 10);
    config.segment_bytes = 16u << 10;
    try {
      auto store = opened(disk, config);
      for (std::size_t step = 0; step < records.size(); ++step) {
        const Record& record = records[step];
        const LogId& log = record.id.log;
        ASSERT_TRUE(store->append(record)) << step << " of " << store->bytes();
        if (step * 7 % 4 == 0) (void)store->sync();
        if (log.lane == 3 && record.id.seq >= 3) (void)store->forget({log, record.id.seq - 3});
        if (log.lane == 4 && record.id.seq >= 1) (void)store->forget({log, record.id.seq - 1});
        for (const auto& [one, count] : store->frontier()) promised[one] = store->durable(one);
      }
      EXPECT_GT(store->view().reclaimed_bytes, 0u) << "segments must have been cleaned, too";
      store->flush();
    } catch (const sim::PowerCut&) {
      crashed = true;
    }
    if (!crashed) {
      EXPECT_EQ(cut, disk.operations()) << "every point was tried";
      break;
    }
    ++crashes;
    disk.come_back();
    auto store = opened(disk, config);
    ASSERT_NE(store, nullptr);
    torn += store->view().cut_bytes > 0 ? 1 : 0;
    for (const auto& [log, count] : promised) {
      const auto at = store->frontier().find(log);
      ASSERT_GE(at == store->frontier().end() ? 0 : at->second, count) << "lost, at point " << cut;
    }
    store->scan([&](const auto& record) {
      const Record& was = written.at(record->id);
      EXPECT_EQ(hash_of(head_of(*record)), hash_of(head_of(was)));
      EXPECT_EQ(record->seal, was.seal);
      if (!record->dropped) {
        EXPECT_EQ(record->body, was.body);
      }
    });
    // And it can go on.
    ASSERT_TRUE(store->append(next_life)) << cut;
    if (testing::Test::HasFatalFailure()) return;
  }
  EXPECT_GT(crashes, 150u);
  EXPECT_GT(torn, 10u) << "the test must have torn something";
}

// What a Node tells its neighbours of itself is never more than what its disk has.
TEST(DiskStoreFaults, ANodeTellsWhatIsDurable) {
  MemoryDisk disk;
  auto store = opened(disk);
  NodeConfig config;
  config.self = kRobot;
  config.identity = sim::identity_of(kRobot);
  Node node(config, *store);
  Instant now{std::chrono::seconds(1)};
  disk.slow = true;
  ASSERT_TRUE(node.append(now, 1, 1, body(100)).ok());
  ASSERT_TRUE(node.append(now, 1, 1, body(100)).ok());
  std::shared_ptr<const Record> record;
  EXPECT_EQ(node.frontier_digest(), 0u);
  EXPECT_FALSE(node.next_applied(record));
  EXPECT_LE(node.next_deadline(), now + std::chrono::milliseconds(2)) << "it looks at the disk again soon";
  now += std::chrono::milliseconds(2);
  node.on_timer(now);
  EXPECT_EQ(node.frontier_digest(), 0u);
  disk.slow = false;
  now += std::chrono::milliseconds(2);
  node.on_timer(now);
  EXPECT_EQ(node.frontier_digest(), entry_digest({kRobot, 1, 1}, 2));
  EXPECT_TRUE(node.next_applied(record));
  OutgoingDatagram datagram;
  while (node.next_outgoing(datagram)) {
  }
  EXPECT_GT(node.next_deadline(), now + std::chrono::milliseconds(20)) << "and then no more";
}

// A sync that fails leaves a record appended and not promised. Neither this node nor the one of the next life, on the
// same store, says that it is there, until it is.
TEST(DiskStoreFaults, NobodyHearsOfWhatASyncDidNotKeep) {
  MemoryDisk disk;
  auto store = opened(disk);
  NodeConfig config;
  config.self = kRobot;
  config.identity = sim::identity_of(kRobot);
  const LogId voxels{kRobot, 3, 1};
  const Instant now{std::chrono::seconds(1)};
  {
    Node node(config, *store);
    ASSERT_TRUE(node.append(now, 3, 1, body(100)).ok());
    ASSERT_EQ(node.frontier_digest(), entry_digest(voxels, 1));
    EXPECT_TRUE(node.own_settled());
    disk.sync_fault = DiskFault::failing;
    ASSERT_TRUE(node.append(now, 3, 1, body(100)).ok());
    EXPECT_EQ(node.frontier_digest(), entry_digest(voxels, 1)) << "the disk has not promised it";
    EXPECT_FALSE(node.own_settled());
  }
  EXPECT_EQ(store->frontier().at(voxels), 2u);
  config.incarnation = 2;
  disk.sync_fault = DiskFault::failing;
  Node next(config, *store);
  EXPECT_EQ(next.frontier_digest(), entry_digest(voxels, 1)) << "nor in the next life";
  EXPECT_FALSE(next.own_settled());
  next.on_timer(now);
  EXPECT_EQ(next.frontier_digest(), entry_digest(voxels, 2)) << "written again, elsewhere";
  EXPECT_TRUE(next.own_settled());
  std::shared_ptr<const Record> record;
  for (std::uint32_t seq = 0; seq < 2; ++seq) {
    ASSERT_TRUE(next.next_applied(record));
    EXPECT_EQ(record->id.seq, seq);
  }
  EXPECT_FALSE(next.next_applied(record));
}

// Writes that succeed and syncs that do not: what waits for a promise stays within its memory.
TEST(DiskStoreFaults, SyncsThatNeverSucceedDoNotFillTheMemory) {
  struct NeverSyncs final : test::PassingDisk {
    using PassingDisk::PassingDisk;
    void begin_sync(const std::string&) override {}
    std::optional<DiskFault> synced(bool) override { return DiskFault::failing; }
  };
  MemoryDisk disk;
  NeverSyncs failing(disk);
  DiskStoreConfig config = small(8u << 20);
  config.waiting_bytes = 20'000;
  auto store = opened(failing, config);
  SignedLogs logs;
  const LogId log{kRobot, 3, 1};
  std::uint32_t kept = 0;
  for (; kept < 1000; ++kept)
    if (!store->append(logs.record({log, kept}, 1, body(1000)))) break;
  EXPECT_LT(kept, 20u);
  EXPECT_EQ(store->durable(log), 0u);
  EXPECT_EQ(store->view().refused_by_disk, 1u);
  EXPECT_EQ(store->view().waiting_records, kept);
}

}  // namespace
}  // namespace onemap::comms
