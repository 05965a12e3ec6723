// The log on a disk that keeps its word.
#include "comms/disk/disk_store.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "comms/disk/posix_disk.hpp"
#include "memory_disk.hpp"
#include "sim_net.hpp"
#include "small_store.hpp"
#include "support/temp_folder.hpp"

namespace onemap::comms {
namespace {

using sim::MemoryDisk;
using sim::SignedLogs;
using test::body;
using test::expect_same;
using test::opened;
using test::small;

const RobotId kAuthor = RobotId::from_name("robot"), kSecondAuthor = RobotId::from_name("other");

TEST(DiskStore, KeepsLogsOverRestarts) {
  MemoryDisk disk;
  SignedLogs logs;
  std::vector<Record> written;
  for (int k = 0; k < 30; ++k)
    written.push_back(logs.next({k % 3 == 0 ? kSecondAuthor : kAuthor, static_cast<std::uint8_t>(k % 5), 1},
                                static_cast<std::uint16_t>(k), body(static_cast<std::size_t>(k * 300 % 9000), 9)));
  VersionVector frontier;
  {
    auto store = opened(disk);
    for (const Record& record : written) ASSERT_TRUE(store->append(record));
    EXPECT_FALSE(store->append(written[3])) << "not the next of its log";
    frontier = store->frontier();
    for (const Record& record : written) {
      expect_same(record, store->read(record.id));
      expect_same(record, store->find(record.id));
    }
    EXPECT_EQ(store->find({{kSecondAuthor, 4, 9}, 0}), nullptr);
    EXPECT_EQ(store->read({{kSecondAuthor, 4, 9}, 0}), nullptr);
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
  const LogId log{kAuthor, 1, 1};
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
  const Record first = logs.next({kAuthor, 1, 1}, 1, body(40)), second = logs.next({kAuthor, 1, 1}, 1, body(40));
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
  EXPECT_FALSE(reader->append(logs.record({{kAuthor, 3, 1}, 0}, 1, body(40)))) << "nothing is written there";
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
  const LogId bulk{kAuthor, 3, 1}, feature{kAuthor, 2, 1}, pose{kAuthor, 1, 1};
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
  while (store->append(logs.next({kSecondAuthor, 3, 1}, 1, body(2000)))) ++greedy;
  EXPECT_LE(greedy * 2000, 180'000u);
  EXPECT_TRUE(store->append(logs.next({kSecondAuthor, 1, 1}, 1, body(2000)))) << "its poses have room still";
  for (int k = 0; k < 80; ++k) EXPECT_TRUE(store->append(logs.next({kAuthor, 3, 1}, 1, body(2000))));
}

TEST(DiskStore, TheIndexIsOfFixedSize) {
  MemoryDisk disk;
  DiskStoreConfig config = small();
  config.index_bytes = 64 * 8 * 10;
  auto store = opened(disk, config);
  std::size_t records = 0;
  while (store->append({{{kAuthor, 1, 1}, static_cast<std::uint32_t>(records)}, 1, {}, {}, {}})) ++records;
  EXPECT_EQ(records, 640u);
  EXPECT_EQ(store->view().refused_full, 1u);
}

// What comms takes: its store, and the block in which the node and its guard live.
TEST(DiskStore, AndTheNodeTakeNoMoreThan16MB) {
  MemoryDisk disk;
  auto store = opened(disk, DiskStoreConfig{});
  EXPECT_LE(store->view().memory_bytes + NodeConfig{}.memory_bytes, 16u << 20);
}

TEST(DiskStore, ForgottenBodiesMakeRoomAndHeadsStay) {
  MemoryDisk disk;
  SignedLogs logs;
  const LogId log{kAuthor, 3, 1}, kept{kAuthor, 1, 1};
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

TEST(PosixDisk, KeepsFilesAndItsFolderToItself) {
  const test::TempFolder folder;
  auto disk = PosixDisk::open(folder / "log");
  ASSERT_TRUE(disk.ok()) << disk.error().text();
  const auto second = PosixDisk::open(folder / "log");
  ASSERT_FALSE(second.ok());
  EXPECT_THAT(second.error().text(), testing::HasSubstr("another process"));
  SignedLogs logs;
  const LogId log{kAuthor, 3, 1};
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
