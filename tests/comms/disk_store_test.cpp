// The log on a disk that keeps its word.
#include "comms/disk/disk_store.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "comms/disk/posix_disk.hpp"
#include "memory_disk.hpp"
#include "sim_net.hpp"
#include "support/temp_folder.hpp"

namespace onemap::comms {
namespace {

using sim::MemoryDisk;
using sim::SignedLogs;

const RobotId kRobot = RobotId::from_name("robot"), kOther = RobotId::from_name("other");

DiskStoreConfig small(std::size_t budget = 1u << 20) {
  DiskStoreConfig config;
  config.budget_bytes = budget;
  config.author_bytes = budget;
  config.segment_bytes = budget / 8;
  config.index_bytes = 64 * 8 * 50;
  config.cache_bytes = 4096;
  return config;
}
std::unique_ptr<DiskStore> opened(Disk& disk, const DiskStoreConfig& config = small()) {
  auto store = DiskStore::open(disk, config);
  return store ? std::move(*store) : nullptr;
}
std::vector<std::uint8_t> body(std::size_t bytes, std::uint8_t value = 7) {
  return std::vector<std::uint8_t>(bytes, value);
}
void expect_same(const Record& there, const std::shared_ptr<const Record>& here) {
  ASSERT_NE(here, nullptr);
  EXPECT_EQ(here->id, there.id);
  EXPECT_EQ(here->kind, there.kind);
  EXPECT_EQ(here->body, there.body);
  EXPECT_EQ(here->seal, there.seal);
  EXPECT_EQ(here->dropped, there.dropped);
}

TEST(DiskStore, KeepsLogsOverRestarts) {
  MemoryDisk disk;
  SignedLogs logs;
  std::vector<Record> written;
  for (int k = 0; k < 30; ++k)
    written.push_back(logs.next({k % 3 == 0 ? kOther : kRobot, static_cast<std::uint8_t>(k % 5), 1},
                                static_cast<std::uint16_t>(k), body(static_cast<std::size_t>(k * 300 % 9000), 9)));
  VersionVector frontier;
  {
    auto store = opened(disk);
    for (const Record& record : written) ASSERT_TRUE(store->append(record));
    EXPECT_FALSE(store->append(written[3])) << "not the next of its log";
    frontier = store->frontier();
    for (const Record& record : written) expect_same(record, store->find(record.id));
    EXPECT_EQ(store->find({{kOther, 4, 9}, 0}), nullptr);
  }
  auto store = opened(disk);
  EXPECT_EQ(store->frontier(), frontier);
  for (const Record& record : written) {
    expect_same(record, store->find(record.id));
    EXPECT_GT(store->durable(record.id.log), record.id.seq);
  }
  std::vector<RecordId> seen;
  store->scan([&](const auto& one) { seen.push_back(one->id); });
  EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
  EXPECT_EQ(seen.size(), written.size());
  EXPECT_TRUE(store->view().messages.empty());
}

// One sync for all that came meanwhile, and nothing counts before it is over.
TEST(DiskStore, DurableIsWhatASyncThatBeganLaterHasEnded) {
  MemoryDisk disk;
  auto store = opened(disk);
  SignedLogs logs;
  const LogId log{kRobot, 1, 1};
  disk.slow = true;
  ASSERT_TRUE(store->append(logs.next(log, 1, body(10))));
  EXPECT_TRUE(store->sync());
  for (int k = 0; k < 9; ++k) ASSERT_TRUE(store->append(logs.next(log, 1, body(10))));
  EXPECT_TRUE(store->sync());
  EXPECT_EQ(store->durable(log), 0u);
  disk.slow = false;
  EXPECT_TRUE(store->sync());
  EXPECT_EQ(store->durable(log), 10u) << "the first one's sync ended, and one for nine more";
  EXPECT_EQ(disk.syncs, 2u);
  EXPECT_TRUE(store->sync());
  EXPECT_EQ(disk.syncs, 2u) << "nothing to do";
}

// Beside whoever writes there.
TEST(DiskStore, AFolderToReadStaysAsItIsAndIsNobodysOwn) {
  const test::TempFolder folder;
  const std::string log = folder / "log";
  const auto own = PosixDisk::open(log);
  ASSERT_TRUE(own.ok());
  const auto store = opened(**own);
  SignedLogs logs;
  const Record first = logs.next({kRobot, 1, 1}, 1, body(40)), second = logs.next({kRobot, 1, 1}, 1, body(40));
  ASSERT_TRUE(store->append(first));
  ASSERT_TRUE(store->append(second));
  std::filesystem::resize_file(log + "/segment-00000001", 224 + 200);  // the second one is torn
  EXPECT_FALSE(PosixDisk::open(log)) << "it is used";
  std::atomic<bool> given_up = false;
  const auto disk = PosixDisk::open_to_read(log, given_up);
  ASSERT_TRUE(disk.ok()) << disk.error().text();
  const auto reader = opened(**disk);
  ASSERT_NE(reader, nullptr);
  expect_same(first, reader->find(first.id));
  EXPECT_EQ(reader->view().records, 1u);
  EXPECT_EQ(reader->view().spoilt_bytes, 200u);
  EXPECT_FALSE(reader->append(logs.record({{kRobot, 3, 1}, 0}, 1, body(40)))) << "nothing is written there";
  EXPECT_EQ(std::filesystem::file_size(log + "/segment-00000001"), 424u);
  EXPECT_EQ((*disk)->remove("segment-00000001"), DiskFault::read_only);
  EXPECT_EQ((*disk)->rename("segment-00000001", "x"), DiskFault::read_only);
  std::array<std::uint8_t, 4> some{};
  EXPECT_EQ((*disk)->read("segment-00000001", 0, some), 4u);
  given_up = true;
  EXPECT_FALSE((*disk)->read("segment-00000001", 0, some));
  EXPECT_FALSE((*disk)->size("segment-00000001"));
  EXPECT_FALSE(PosixDisk::open_to_read(folder / "none", given_up));
  EXPECT_FALSE(std::filesystem::exists(folder / "none"));
}

TEST(DiskStore, FullRefusesVoxelsFirstAndSaysWhy) {
  MemoryDisk disk;
  auto store = opened(disk, small(1u << 20));
  SignedLogs logs;
  std::size_t voxels = 0, features = 0, poses = 0;
  const LogId bulk{kRobot, 3, 1}, feature{kRobot, 2, 1}, pose{kRobot, 1, 1};
  while (store->append(logs.next(bulk, 1, body(2000)))) ++voxels;
  const auto refused = store->append(logs.record({bulk, static_cast<std::uint32_t>(voxels)}, 1, body(2000)));
  EXPECT_THAT(refused.error().text(), testing::HasSubstr("network.store_budget_mb"));
  EXPECT_THAT(refused.error().text(), testing::HasSubstr("the last tenth is for control, poses and features"));
  const auto seq = static_cast<std::uint32_t>(voxels);
  EXPECT_FALSE(store->append(logs.record({bulk, seq}, 1, body(1500), 0)));
  EXPECT_TRUE(store->append(logs.record({bulk, seq}, 1, body(30), 0))) << "it names one that makes room";
  while (store->append(logs.next(feature, 1, body(2000)))) ++features;
  while (store->append(logs.next(pose, 1, body(2000)))) ++poses;
  EXPECT_GE(voxels, 300u);
  EXPECT_GE(features, 15u) << "without which voxels have no place";
  EXPECT_GE(poses, 15u);
  EXPECT_LE(store->bytes(), 1u << 20);
  EXPECT_EQ(store->view().refused_full, 5u);
}

TEST(DiskStore, OneRobotDoesNotFillItForAll) {
  MemoryDisk disk;
  DiskStoreConfig config = small();
  config.author_bytes = 200'000;
  auto store = opened(disk, config);
  SignedLogs logs;
  std::size_t greedy = 0;
  while (store->append(logs.next({kOther, 3, 1}, 1, body(2000)))) ++greedy;
  EXPECT_LE(greedy * 2000, 180'000u);
  EXPECT_TRUE(store->append(logs.next({kOther, 1, 1}, 1, body(2000)))) << "its poses have room still";
  for (int k = 0; k < 80; ++k) EXPECT_TRUE(store->append(logs.next({kRobot, 3, 1}, 1, body(2000))));
}

TEST(DiskStore, TheIndexIsOfFixedSize) {
  MemoryDisk disk;
  DiskStoreConfig config = small();
  config.index_bytes = 64 * 8 * 10;
  auto store = opened(disk, config);
  std::size_t records = 0;
  while (store->append({{{kRobot, 1, 1}, static_cast<std::uint32_t>(records)}, 1, {}, {}, {}})) ++records;
  EXPECT_EQ(records, 640u);
  EXPECT_EQ(store->view().refused_full, 1u);
}

TEST(DiskStore, ForgottenBodiesMakeRoomAndHeadsStay) {
  MemoryDisk disk;
  SignedLogs logs;
  const LogId log{kRobot, 3, 1}, kept{kRobot, 1, 1};
  std::vector<Record> heads, poses;
  {
    auto store = opened(disk);
    // Six times what the budget holds, of which the newest 40 count.
    for (std::uint32_t k = 0; k < 1500; ++k) {
      const Record record = logs.next(log, 4, body(4000, static_cast<std::uint8_t>(k)));
      ASSERT_TRUE(store->append(record)) << k << ": " << store->view().bytes;
      heads.push_back(without_body(record));
      if (k % 10 == 0) {
        poses.push_back(logs.next(kept, 2, body(100, static_cast<std::uint8_t>(k))));
        ASSERT_TRUE(store->append(poses.back()));
      }
      ASSERT_TRUE(store->sync());
      if (k >= 40) {
        ASSERT_TRUE(store->forget({log, k - 40}));
      }
    }
    EXPECT_FALSE(store->forget({log, 3})) << "it is gone";
    EXPECT_FALSE(store->forget({log, 5000})) << "it was never here";
    EXPECT_LE(store->bytes(), 1u << 20);
    EXPECT_GT(store->view().reclaimed_bytes, 3u << 20);
    for (std::uint32_t k = 0; k < 1460; k += 7) expect_same(heads[k], store->find({log, k}));
    for (const Record& pose : poses) expect_same(pose, store->find(pose.id));
  }
  auto store = opened(disk);
  EXPECT_EQ(store->frontier().at(log), 1500u);
  for (std::uint32_t k = 0; k < 1500; k += 7) {
    const auto record = store->find({log, k});
    ASSERT_NE(record, nullptr);
    EXPECT_EQ(hash_of(head_of(*record)), hash_of(head_of(heads[k]))) << "the chain is whole";
    if (k >= 1460) {
      EXPECT_EQ(record->body.size(), 4000u);
    }
  }
  for (const Record& pose : poses) expect_same(pose, store->find(pose.id));
}

// Full, read-only, failing, gone: a state with a word; poses go on, and all is written when the disk is back.
TEST(DiskStore, ADiskThatDoesNotWorkStopsVoxelsAndNotPoses) {
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
TEST(DiskStore, WhatASyncDidNotKeepIsWrittenAgain) {
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

TEST(DiskStore, SetsAsideWhatIsNoLogAndGoesOn) {
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
TEST(DiskStore, ASpoiltPlaceCostsOneLogItsEnd) {
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

// The power goes at every point at which the disk changes, with everything torn that may be: what was durable is there
// as it was, and what else is there is whole.
TEST(DiskStore, NoPointOfACrashLosesWhatWasDurable) {
  SignedLogs logs;
  test::Random random(5);
  std::vector<Record> records;
  std::map<RecordId, Record> written;
  for (std::size_t step = 0; step < 160; ++step) {
    const LogId log{step % 3 == 0 ? kOther : kRobot, static_cast<std::uint8_t>(random.below(5)), 1};
    records.push_back(logs.next(log, 1, body(random.below(3000), static_cast<std::uint8_t>(step))));
    written.emplace(records.back().id, records.back());
  }
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
TEST(DiskStore, ANodeTellsWhatIsDurable) {
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
TEST(DiskStore, NobodyHearsOfWhatASyncDidNotKeep) {
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
TEST(DiskStore, SyncsThatNeverSucceedDoNotFillTheMemory) {
  class NeverSyncs final : public Disk {
   public:
    explicit NeverSyncs(MemoryDisk& disk) : disk_(disk) {}
    std::optional<std::vector<std::string>> list() override { return disk_.list(); }
    std::optional<std::uint64_t> size(const std::string& name) override { return disk_.size(name); }
    std::optional<std::size_t> read(const std::string& name, std::uint64_t at, std::span<std::uint8_t> into) override {
      return disk_.read(name, at, into);
    }
    DiskFault write(const std::string& name, std::uint64_t at, std::span<const std::uint8_t> bytes) override {
      return disk_.write(name, at, bytes);
    }
    DiskFault cut(const std::string& name, std::uint64_t size) override { return disk_.cut(name, size); }
    DiskFault remove(const std::string& name) override { return disk_.remove(name); }
    DiskFault rename(const std::string& name, const std::string& to) override { return disk_.rename(name, to); }
    void begin_sync(const std::string&) override {}
    std::optional<DiskFault> synced(bool) override { return DiskFault::failing; }

   private:
    MemoryDisk& disk_;
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

TEST(PosixDisk, KeepsFilesAndItsFolderToItself) {
  const test::TempFolder folder;
  auto disk = PosixDisk::open(folder / "log");
  ASSERT_TRUE(disk.ok()) << disk.error().text();
  const auto second = PosixDisk::open(folder / "log");
  ASSERT_FALSE(second.ok());
  EXPECT_THAT(second.error().text(), testing::HasSubstr("another process"));
  SignedLogs logs;
  const LogId log{kRobot, 3, 1};
  {
    auto store = opened(**disk);
    for (int k = 0; k < 100; ++k) ASSERT_TRUE(store->append(logs.next(log, 1, body(3000))));
    store->flush();
    EXPECT_EQ(store->durable(log), 100u);
    EXPECT_EQ(store->view().waiting_records, 0u);
  }
  auto store = opened(**disk);
  EXPECT_EQ(store->frontier().at(log), 100u);
  EXPECT_EQ(store->find({log, 99})->body, body(3000));
  // Somebody takes the folder away.
  std::filesystem::remove_all(folder.path() / "log");
  ASSERT_TRUE(store->append(logs.next(log, 1, body(3000)))) << "the open file takes it";
  (void)store->sync();
  store->flush();
  EXPECT_EQ(store->durable(log), 100u);
  EXPECT_EQ(store->view().fault, DiskFault::gone);
  EXPECT_FALSE(PosixDisk::open("/proc/nothing").ok());
}

}  // namespace
}  // namespace onemap::comms
