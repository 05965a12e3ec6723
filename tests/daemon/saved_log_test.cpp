// Records go into a folder: those that are durable, and the folder whole or not at all.
#include "daemon/saved_log.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "support/kept_log.hpp"
#include "support/memory_disk.hpp"
#include "support/signed_logs.hpp"
#include "support/temp_folder.hpp"

namespace onemap::daemon {
namespace {

namespace fs = std::filesystem;
using comms::sim::MemoryDisk;
using test::Kept;
using test::taken;
using testing::HasSubstr;

const LogId kPoses{RobotId::from_name("ada"), 1, 5}, kOthers{RobotId::from_name("bob"), 1, 2};

struct SavedRecords : testing::Test {
  const test::TempFolder out;
  const std::string log = out / "log", saved = out / "house.log";
  std::atomic<bool> stop = false;
  comms::sim::SignedLogs logs;
  static std::vector<std::uint8_t> body(std::size_t bytes) { return std::vector<std::uint8_t>(bytes, 7); }
};

TEST_F(SavedRecords, OnlyWhatIsDurableIsSaved) {
  MemoryDisk disk;
  const auto store = taken(comms::DiskStore::open(disk, {}));
  for (int k = 0; k < 4; ++k) ASSERT_TRUE(store->append(logs.next(kPoses, 1, body(10))));
  store->flush();
  disk.slow = true;
  ASSERT_TRUE(store->append(logs.next(kPoses, 1, body(10))));
  ASSERT_TRUE(store->append(logs.next(kOthers, 1, body(10))));
  EXPECT_EQ(durable_part(*store), (VersionVector{{kPoses, 4}}));
  const auto done = SavedLog::save(*store, durable_part(*store), saved, stop);
  ASSERT_TRUE(done.ok()) << done.error().text();
  EXPECT_EQ(done->records, 4u);
  disk.slow = false;
}

// A store of which one record cannot be read.
struct Unreadable final : comms::LogStore {
  const comms::LogStore& all;
  RecordId not_this;
  std::function<void()> before_find = [] {};
  Unreadable(const comms::LogStore& of, RecordId id) : all(of), not_this(id) {}
  Status append(Record) override { return Error{"", "no"}; }
  Status sync() override { return success(); }
  std::uint32_t durable(const LogId& log) const override { return all.durable(log); }
  std::shared_ptr<const Record> find(const RecordId& id) const override {
    before_find();
    return id == not_this ? nullptr : all.find(id);
  }
  void scan(const std::function<void(const std::shared_ptr<const Record>&)>&) const override {}
  bool forget(const RecordId&) override { return false; }
  const VersionVector& frontier() const override { return all.frontier(); }
  std::size_t bytes() const override { return all.bytes(); }
};

TEST_F(SavedRecords, WhatCannotBeReadIsLeftOutAndSaid) {
  const Kept kept(log);
  for (int k = 0; k < 6; ++k) ASSERT_TRUE(kept.store->append(logs.next(kPoses, 1, body(10))));
  ASSERT_TRUE(kept.store->append(logs.next(kOthers, 1, body(10))));
  const Unreadable from(*kept.store, {kPoses, 4});
  const auto done = SavedLog::save(from, from.frontier(), saved, stop);
  ASSERT_TRUE(done.ok());
  EXPECT_EQ(done->records, 5u);
  EXPECT_EQ(done->left_out, 2u);
}

// A body that goes between the look at the log and its copy: a head says nothing without the record that replaces it.
TEST_F(SavedRecords, ABodyThatGoesMeanwhileTakesWhatReplacesItAlong) {
  const Kept kept(log);
  for (int k = 0; k < 3; ++k) ASSERT_TRUE(kept.store->append(logs.next(kPoses, 1, body(10))));
  const VersionVector before = kept.store->frontier();
  ASSERT_TRUE(kept.store->append(logs.next(kPoses, 1, body(10))));
  ASSERT_TRUE(kept.store->append(logs.next(kPoses, 1, body(10), 2)));  // replaces the third
  ASSERT_TRUE(kept.store->append(logs.next(kPoses, 1, body(10))));
  ASSERT_TRUE(kept.store->forget({kPoses, 2}));
  int asked = 0;
  const auto durable = [&](const LogId&) -> std::uint32_t { return ++asked < 3 ? 4 : 5; };
  const auto done = SavedLog::save(*kept.store, before, saved, stop, durable);
  ASSERT_TRUE(done.ok()) << done.error().text();
  EXPECT_EQ(done->records, 5u) << "up to the one that replaces it, and no more";
  EXPECT_EQ(done->left_out, 0u);
}

TEST_F(SavedRecords, AFolderIsThereWholeOrNotAtAll) {
  const Kept kept(log);
  Unreadable from(*kept.store, {});
  EXPECT_THAT(SavedLog::save(from, from.frontier(), saved, stop).error().text(), HasSubstr("no record yet"));
  for (int k = 0; k < 6; ++k) ASSERT_TRUE(kept.store->append(logs.next(kPoses, 1, body(10))));
  from.before_find = [&] {
    EXPECT_FALSE(fs::exists(saved));
    stop = true;
  };
  EXPECT_THAT(SavedLog::save(from, from.frontier(), saved, stop).error().text(), HasSubstr("the daemon is ending"));
  EXPECT_FALSE(fs::exists(saved) || fs::exists(saved + ".partial"));
  stop = false;
  from.before_find = [] {};
  fs::create_directory(saved + ".partial");  // a life that was killed left that
  std::ofstream(saved + ".partial/segment-00000001") << std::string(500, 'x');
  ASSERT_TRUE(SavedLog::save(from, from.frontier(), saved, stop).ok());
  EXPECT_FALSE(fs::exists(saved + ".partial"));
  EXPECT_EQ(std::distance(fs::directory_iterator(saved), {}), 1) << "and nothing of that";
  EXPECT_THAT(SavedLog::save(from, from.frontier(), saved, stop).error().text(), HasSubstr("it is there already"));
  EXPECT_THAT(SavedLog::save(from, from.frontier(), out / "none/x.log", stop).error().text(), HasSubstr("none/x.log"));
}

}  // namespace
}  // namespace onemap::daemon
