// Records that came on another way than over the network are looked at like any other.
#include <gtest/gtest.h>

#include "alone_node.hpp"
#include "comms/record_head.hpp"

namespace onemap::comms {
namespace {
using sim::Alone;
using sim::SignedLogs;

const LogId kLog{RobotId::from_name("friend"), 2, 5};
const std::vector<std::uint8_t> kBody{1, 2, 3};

NodeConfig config_with_keeping() {
  NodeConfig config;
  config.keeping = [](std::uint16_t kind) { return kind == 4 ? Keeping::until_it_may_go : Keeping::always; };
  return config;
}

TEST(TakenRecords, AreHereAndGivenOut) {
  Alone alone;
  SignedLogs logs;
  for (std::uint32_t seq = 0; seq < 3; ++seq)
    EXPECT_EQ(alone.node.take(alone.now, logs.next(kLog, 1, kBody), {}), Refusal::count);
  EXPECT_EQ(alone.node.frontier(), (VersionVector{{kLog, 3}}));
  std::shared_ptr<const Record> record;
  int given = 0;
  for (; alone.node.next_applied(record); ++given) EXPECT_EQ(record->body, kBody);
  EXPECT_EQ(given, 3);
}

TEST(TakenRecords, AreTheirAuthorsOrRefused) {
  Alone alone;
  SignedLogs logs, others;
  Record spoilt = logs.next(kLog, 1, kBody);
  spoilt.body[0] ^= 1;
  EXPECT_EQ(alone.node.take(alone.now, spoilt, {}), Refusal::bad_signature);
  const Record first = logs.record({kLog, 0}, 1, kBody), second = logs.next(kLog, 1, kBody),
               third = logs.next(kLog, 1, kBody);
  EXPECT_EQ(alone.node.take(alone.now, second, {}), Refusal::data_unasked) << "whose key that is nobody knows";
  EXPECT_EQ(alone.node.take(alone.now, first, {}), Refusal::count);
  EXPECT_EQ(alone.node.take(alone.now, third, {}), Refusal::data_unasked) << "one is left out";
  EXPECT_EQ(alone.node.take(alone.now, second, {}), Refusal::count);
  EXPECT_EQ(alone.node.take(alone.now, second, {}), Refusal::data_unasked) << "it is here";
  EXPECT_EQ(alone.node.frontier(), (VersionVector{{kLog, 2}}));
  EXPECT_EQ(alone.node.counters().of(Refusal::data_unasked), 3u);
}

TEST(TakenRecords, OfAnotherHistoryAreRefusedAndTheLogGoesOn) {
  Alone alone;
  SignedLogs logs, another;
  ASSERT_EQ(alone.node.take(alone.now, logs.next(kLog, 1, kBody), {}), Refusal::count);
  another.next(kLog, 1, {9});
  EXPECT_EQ(alone.node.take(alone.now, another.next(kLog, 1, kBody), {}), Refusal::forked);
  EXPECT_EQ(alone.node.take(alone.now, logs.next(kLog, 1, kBody), {}), Refusal::count) << "who is honest is heard";
}

// What a neighbour sends meanwhile, and what waited for them.
TEST(TakenRecords, FitTogetherWithWhatComesOverTheNetwork) {
  Alone alone;
  SignedLogs logs;
  const LogId pushed{kLog.robot, 1, 5};
  const Record first = logs.next(pushed, 1, kBody), second = logs.next(pushed, 1, kBody);
  alone.befriend();
  alone.hear_record(5, 2, second);
  EXPECT_TRUE(alone.node.frontier().empty()) << "it waits for the one before";
  EXPECT_TRUE(sim::first<wire::Want>(alone.sent_within(std::chrono::milliseconds(100)))) << "which is asked for";
  EXPECT_EQ(alone.node.take(alone.now, first, {}), Refusal::count);
  EXPECT_EQ(alone.node.frontier(), (VersionVector{{pushed, 2}}));
  alone.hear_record(5, 3, first);
  EXPECT_EQ(alone.node.frontier(), (VersionVector{{pushed, 2}}));
  EXPECT_EQ(alone.node.records_missing(), 0u);
}

TEST(TakenRecords, OfARobotWhoseKeyIsKnownAreItsOwnOrRefused) {
  Alone alone;
  SignedLogs logs;
  ASSERT_TRUE(alone.node.pin(kLog.robot, sim::identity_of(RobotId::from_name("other")).public_key()));
  EXPECT_EQ(alone.node.take(alone.now, logs.next(kLog, 1, kBody), {}), Refusal::second_key);
}

TEST(TakenRecords, HaveTheRoomThatANeighboursHave) {
  NodeConfig config;
  config.max_logs_of_robot = 2;
  Alone alone(config, 4096);
  SignedLogs logs;
  for (std::uint8_t lane = 0; lane < 3; ++lane) {
    const Record first = logs.next({kLog.robot, lane, 5}, 1, kBody);
    EXPECT_EQ(alone.node.take(alone.now, first, {}), lane < 2 ? Refusal::count : Refusal::robot_logs_full);
  }
  EXPECT_EQ(alone.node.take(alone.now, logs.next({kLog.robot, 1, 5}, 1, std::vector<std::uint8_t>(4000)), {}),
            Refusal::store_refused);
}

TEST(TakenRecords, NobodyWritesThisRobotsPresentOrLaterLife) {
  Alone alone;
  for (const std::uint64_t life : {Alone::kLife, Alone::kLife + 1}) {
    SignedLogs logs;
    const Record record = logs.next({RobotId::from_name("self"), 1, life}, 1, kBody);
    const Refusal present = life == Alone::kLife ? Refusal::own_log_ahead : Refusal::later_life;
    EXPECT_EQ(alone.node.take(alone.now, record, {}), present);
  }
  SignedLogs logs;
  EXPECT_EQ(alone.node.take(alone.now, logs.next({RobotId::from_name("self"), 1, 3}, 1, kBody), {}), Refusal::count);
}

TEST(TakenRecords, WithoutABodyNeedTheirAuthorsWord) {
  Alone alone(config_with_keeping());
  SignedLogs logs;
  const Record first = logs.next(kLog, 4, kBody), other = logs.next(kLog, 4, {9}), later = logs.next(kLog, 4, {7}, 0);
  const SignedHead by{head_of(later), later.seal.signature};
  const Record bare = without_body(first);
  EXPECT_EQ(alone.node.take(alone.now, bare, {}), Refusal::live_head);
  EXPECT_EQ(alone.node.take(alone.now, bare, SignedHead{head_of(other), other.seal.signature}), Refusal::live_head);
  SignedHead forged = by;
  forged.signature[0] ^= 1;
  EXPECT_EQ(alone.node.take(alone.now, bare, forged), Refusal::live_head);
  EXPECT_EQ(alone.node.take(alone.now, bare, by), Refusal::count);
}

}  // namespace
}  // namespace onemap::comms
