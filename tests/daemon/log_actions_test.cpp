// Records go into a folder and come out of it: whole, or said why not.
#include "daemon/control/log_actions.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "comms/memory_store.hpp"
#include "daemon/saved_log.hpp"
#include "support/kept_log.hpp"
#include "support/memory_disk.hpp"
#include "support/signed_logs.hpp"
#include "support/temp_folder.hpp"
#include "support/text_of.hpp"

namespace onemap::daemon {
namespace {

namespace fs = std::filesystem;
using comms::sim::identity_of;
using comms::sim::MemoryDisk;
using comms::sim::SignedLogs;
using test::Kept;
using test::taken;
using testing::AllOf;
using testing::HasSubstr;

const RobotId kAda = RobotId::from_name("ada"), kBob = RobotId::from_name("bob"), kSelf = RobotId::from_name("self");
const LogId kPoses{kAda, 1, 5}, kVoxels{kAda, 3, 5}, kOthers{kBob, 1, 2};
constexpr std::uint64_t kLife = 77;
constexpr std::uint16_t kMayGo = 4;
std::vector<std::uint8_t> body(std::size_t bytes, std::uint8_t value = 7) {
  return std::vector<std::uint8_t>(bytes, value);
}

comms::NodeConfig node_config() {
  comms::NodeConfig config;
  config.self = kSelf;
  config.incarnation = kLife;
  config.identity = identity_of(kSelf);
  config.keeping = [](std::uint16_t kind) {
    return kind == kMayGo ? comms::Keeping::until_it_may_go : comms::Keeping::always;
  };
  return config;
}

// A robot whose radio is whoever asks.
struct Robot {
  std::unique_ptr<comms::LogStore> store;
  comms::Node node;
  int asked = 0;
  std::function<void()> before_asked = [] {};
  OwnRecords own{[this](const Radio::Question& question, const std::atomic<bool>& stop) {
    ++asked;
    before_asked();
    if (!stop) question(node, *store);
    return !stop;
  }};

  explicit Robot(std::unique_ptr<comms::LogStore> of = std::make_unique<comms::MemoryStore>(16u << 20))
      : store(std::move(of)), node(node_config(), *store) {}
};

struct LogActions : testing::Test {
  const test::TempFolder out;
  const std::string log = out / "log", saved = out / "house.log";
  std::atomic<bool> stop = false;
  SignedLogs logs;

  // The log of two robots; three bodies are gone, and what came instead is there.
  void keep_a_team() {
    Kept kept(log);
    for (int k = 0; k < 70; ++k) kept.append(logs.next(kPoses, 1, body(200)));
    for (int k = 0; k < 20; ++k)
      kept.append(logs.next(kVoxels, kMayGo, body(20'000), k >= 10 && k < 13 ? k - 10 : kNoSequence));
    for (int k = 0; k < 3; ++k) kept.append(logs.next(kOthers, 1, body(30)));
    for (std::uint32_t seq = 0; seq < 3; ++seq) ASSERT_TRUE(kept.store->forget({kVoxels, seq}));
    Robot robot;
    robot.own = {[&](const Radio::Question& question, const auto&) { return question(robot.node, *kept.store), true; },
                 kept.store.get()};
    kept.store->flush();
    const auto done = save_records(robot.own, saved, stop);
    ASSERT_TRUE(done.ok()) << done.error().text();
    EXPECT_EQ(done->value("records", 0), 93);
    EXPECT_EQ(done->value("left_out", -1), 0);
    EXPECT_EQ(done->value("bytes", 0u), fs::file_size(first_segment()));
  }
  // A log of what one robot wrote, saved; `append` may write what no honest robot does.
  void keep(const std::vector<Record>& records) {
    Kept kept(log);
    for (const Record& record : records) kept.append(record);
    kept.store->flush();
    ASSERT_TRUE(SavedLog::save(*kept.store, kept.store->frontier(), saved, stop).ok());
  }
  std::string first_segment() const { return saved + "/segment-00000001"; }
  void spoil(std::uint64_t at) const {
    std::fstream(first_segment(), std::ios::in | std::ios::out | std::ios::binary)
        .seekp(static_cast<std::streamoff>(at))
        .write("spoilt, and not by one bit", 26);
  }
  Json load(Robot& robot) {
    const auto loaded = load_records(robot.own, saved, stop);
    EXPECT_TRUE(loaded.ok()) << loaded.error().text();
    return loaded.ok() ? *loaded : Json::object();
  }
  std::string why_not(Robot& robot) {
    const auto loaded = load_records(robot.own, saved, stop);
    EXPECT_FALSE(loaded.ok());
    return loaded.ok() ? "" : loaded.error().text();
  }
};

TEST_F(LogActions, WhatOneRobotSavedAnotherHolds) {
  keep_a_team();
  Robot robot;
  const Json all = load(robot);
  EXPECT_EQ(all.value("records", 0), 93) << all.dump();
  EXPECT_EQ(all.value("taken", 0), 93) << all.dump();
  EXPECT_EQ(all.value("known", -1), 0);
  EXPECT_TRUE(all.value("refused", Json()).empty()) << all.dump();
  EXPECT_EQ(all.value("spoilt_bytes", -1), 0);
  EXPECT_EQ(robot.node.frontier(), (VersionVector{{kPoses, 70}, {kVoxels, 20}, {kOthers, 3}}));
  EXPECT_TRUE(robot.store->find({kVoxels, 2})->dropped.has_value());
  EXPECT_EQ(robot.store->find({kVoxels, 13})->body, body(20'000));
  const Json again = load(robot);
  EXPECT_EQ(again.value("known", 0), 93) << again.dump();
  EXPECT_EQ(again.value("taken", -1), 0);
}

TEST_F(LogActions, ManPageHasEveryKeyOfTheAnswers) {
  keep_a_team();
  Robot robot;
  const std::string page = test::text_of(std::string(ONEMAP_SOURCE_DIR) + "/share/man/onemap-control.7");
  const Json answer = load(robot);
  for (const auto& [key, value] : answer.items()) EXPECT_THAT(page, HasSubstr(key));
  EXPECT_THAT(page, HasSubstr("left_out"));
}

TEST_F(LogActions, OnlyWhatIsMissingIsTaken) {
  keep_a_team();
  Robot robot;
  SignedLogs same;
  for (int k = 0; k < 40; ++k)
    ASSERT_EQ(robot.node.take({}, same.next(kPoses, 1, body(200)), {}), comms::Refusal::count);
  const Json all = load(robot);
  EXPECT_EQ(all.value("known", 0), 40) << all.dump();
  EXPECT_EQ(all.value("taken", 0), 53) << all.dump();
}

TEST_F(LogActions, AFolderThatIsReadStaysAsItIs) {
  keep_a_team();
  fs::resize_file(first_segment(), fs::file_size(first_segment()) - 5);
  std::ofstream(saved + "/segment-000000ff") << "no record";
  const auto all = [&] {
    std::map<std::string, std::string> files;
    for (const auto& file : fs::directory_iterator(saved))
      files[file.path().filename().string()] = test::text_of(file.path().string());
    return files;
  };
  const auto before = all();
  EXPECT_EQ(before.size(), 2u) << "no lock is left";
  Robot robot;
  load(robot);
  EXPECT_EQ(all(), before);
}

TEST_F(LogActions, WhatIsSpoiltIsSaidAndTheRestIsTaken) {
  keep_a_team();
  spoil(2'000);  // in the sixth record, of 70
  Robot robot;
  const Json some = load(robot);
  EXPECT_EQ(some.value("taken", 0), 28) << some.dump();
  EXPECT_EQ(some.value("unreadable", 0), 64) << "what follows it in its log: " << some.dump();
  EXPECT_GE(some.value("spoilt_bytes", 0), 384) << some.dump();
  EXPECT_EQ(robot.node.frontier().at(kPoses), 5u);
  EXPECT_EQ(robot.node.frontier().at(kVoxels), 20u);
}

TEST_F(LogActions, ATornFileIsSaid) {
  keep_a_team();
  fs::resize_file(first_segment(), fs::file_size(first_segment()) - 300);  // 240 a record
  Robot robot;
  const Json some = load(robot);
  EXPECT_EQ(some.value("taken", 0), 91) << some.dump();
  EXPECT_GT(some.value("spoilt_bytes", 0), 0) << some.dump();
}

TEST_F(LogActions, WhatIsNotItsAuthorsIsRefusedByReasonAndTheOtherLogsAreTaken) {
  Record forged = logs.next(kPoses, 1, body(10));
  forged.seal.signature[0] ^= 1;
  std::vector<Record> all{forged};
  for (int k = 0; k < 4; ++k) all.push_back(logs.next(kPoses, 1, body(10)));
  for (int k = 0; k < 2; ++k) all.push_back(logs.next(kOthers, 1, body(10)));
  keep(all);
  Robot robot;
  const Json some = load(robot);
  EXPECT_EQ(some["refused"], (Json{{"bad_signature", 5}})) << "and what follows it";
  EXPECT_EQ(some.value("taken", 0), 2) << some.dump();
  EXPECT_EQ(robot.node.counters().of(comms::Refusal::bad_signature), 1u);
  EXPECT_EQ(robot.node.frontier(), (VersionVector{{kOthers, 2}}));
}

TEST_F(LogActions, ANameWithAnotherKeyIsRefused) {
  keep({logs.next(kPoses, 1, body(10)), logs.next(kPoses, 1, body(10))});
  Robot robot;
  ASSERT_TRUE(robot.node.pin(kAda, identity_of(kBob).public_key()));
  EXPECT_THAT(why_not(robot), AllOf(HasSubstr("none of its records"), HasSubstr("another key"), HasSubstr(": 2")));
}

TEST_F(LogActions, ThisRobotsOwnRecordsAreItsEarlierLivesOrRefused) {
  std::vector<Record> all;
  for (const std::uint64_t life : {kLife - 1, kLife, kLife + 1})
    for (int k = 0; k < 3; ++k) all.push_back(logs.next({kSelf, 1, life}, 1, body(10)));
  keep(all);
  Robot robot;
  const Json some = load(robot);
  EXPECT_EQ(some.value("taken", 0), 3) << some.dump();
  EXPECT_EQ(some["refused"], (Json{{"own_log_ahead", 3}, {"later_life", 3}}));
}

TEST_F(LogActions, AStoreThatIsFullRefuses) {
  keep_a_team();
  Robot robot(std::make_unique<comms::MemoryStore>(100'000));
  const Json some = load(robot);
  EXPECT_GT(some["refused"].value("store_refused", 0), 10) << some.dump();
  EXPECT_EQ(robot.node.frontier().at(kPoses), 70u);
  EXPECT_EQ(some.value("taken", 0) + some["refused"].value("store_refused", 0), 93);
}

// A batch at a time, so that no more waits for the disk than it takes.
TEST_F(LogActions, WhatWasTakenIsDurableBeforeMoreIsTaken) {
  keep_a_team();
  MemoryDisk disk;
  disk.slow = true;
  Robot robot(taken(comms::DiskStore::open(disk, {})));
  robot.before_asked = [&] {
    if (robot.asked != 8) return;
    std::size_t taken = 0;
    for (const auto& [id, count] : robot.node.frontier()) taken += count;
    EXPECT_EQ(taken, SavedLog::kMostRecords);
    disk.slow = false;
  };
  EXPECT_EQ(load(robot).value("taken", 0), 93);
  for (const auto& [id, count] : robot.node.frontier()) EXPECT_EQ(robot.store->durable(id), count);
}

TEST_F(LogActions, ADiskThatFailsEndsItWithAWord) {
  keep_a_team();
  MemoryDisk disk;
  Robot robot(taken(comms::DiskStore::open(disk, {})));
  robot.before_asked = [&] {
    disk.sync_fault = disk.fault = robot.asked > 6 ? comms::DiskFault::no_space : disk.fault;
  };
  EXPECT_THAT(why_not(robot), AllOf(HasSubstr("is full"), HasSubstr("records were taken")));
}

TEST_F(LogActions, WhereThereIsNothingThatIsSaid) {
  Robot robot;
  EXPECT_THAT(why_not(robot), HasSubstr("cannot open this folder"));
  std::ofstream(saved) << "a file";
  EXPECT_THAT(why_not(robot), HasSubstr("cannot open this folder"));
  fs::remove(saved);
  fs::create_directory(saved);
  EXPECT_THAT(why_not(robot), HasSubstr("no record that this version of onemap can read"));
  ASSERT_EQ(mkfifo(first_segment().c_str(), 0600), 0);  // nobody ever writes into it
  EXPECT_THAT(why_not(robot), HasSubstr("no record"));
  std::ofstream(saved + "/segment-00000002") << std::string(5'000, 'x');
  EXPECT_THAT(why_not(robot), HasSubstr("5000 bytes are none"));
}

TEST_F(LogActions, TheEndOfTheDaemonEndsIt) {
  keep_a_team();
  Robot robot;
  robot.before_asked = [&] { stop = robot.asked > 3; };
  EXPECT_THAT(why_not(robot), HasSubstr("the daemon is ending"));
  EXPECT_FALSE(robot.node.frontier().contains(kOthers));
}

TEST_F(LogActions, WithoutALogOnTheDiskThereIsNothingToSave) {
  Robot robot;
  const auto done = save_records(robot.own, saved, stop);
  ASSERT_FALSE(done.ok());
  EXPECT_THAT(done.error().text(), HasSubstr("store.keep"));
}

}  // namespace
}  // namespace onemap::daemon
