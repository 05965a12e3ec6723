#include "daemon/publisher.hpp"

#include <gtest/gtest.h>

#include <condition_variable>
#include <mutex>
#include <stdexcept>
#include <vector>

#include "daemon/clock.hpp"
#include "mapping/local/local_mapper.hpp"
#include "support/running.hpp"

namespace onemap::daemon {
namespace {

using What = Publisher::Sealed::What;
using WhenFull = Publisher::WhenFull;

// Takes records; holds the publisher's thread in the first one until it is let go.
struct Gate {
  std::mutex mutex;
  std::condition_variable changed;
  bool open = false;
  std::vector<OutgoingRecord> records;
  std::uint32_t frames = 0;
  std::vector<std::pair<std::uint32_t, std::size_t>> chains;  // frames of each, and records before its end

  Outbox outbox() {
    return {[this](OutgoingRecord record) {
              std::unique_lock lock(mutex);
              changed.wait(lock, [&] { return open; });
              records.push_back(std::move(record));
            },
            [this](std::uint32_t n) { frames = n; },
            [this](std::uint32_t n) { chains.emplace_back(n, records.size()); }};
  }
  void let_go() {
    const std::lock_guard lock(mutex);
    open = true;
    changed.notify_all();
  }
};

void fill_poses(Publisher::Sealed& slot, int first) {
  slot.what = What::poses;
  slot.poses.poses.clear();
  mapping::StampedPose pose;
  pose.time = frame_time_from_ns(first);
  pose.T_robot_camera.q_wxyz = {1 << 30, 0, 0, 0};
  slot.poses.poses.push_back(pose);
}

TEST(Publisher, EncodesInOrderAndFinishesAfterTheLast) {
  Gate gate;
  gate.let_go();
  Failures failures;
  Publisher publisher({}, WhenFull::wait, gate.outbox(), failures);
  publisher.start();
  for (int k = 0; k < 100; ++k) {
    Publisher::Sealed* slot = publisher.slot();
    ASSERT_NE(slot, nullptr);
    fill_poses(*slot, k);
    publisher.publish(slot);
  }
  publisher.finish(123);
  publisher.join();
  ASSERT_EQ(gate.records.size(), 100u);
  for (int k = 0; k < 100; ++k) {
    const OutgoingRecord& record = gate.records[static_cast<std::size_t>(k)];
    EXPECT_EQ(record.lane, mapping::Lane::poses);
    EXPECT_EQ(record.poses, 1u);
    EXPECT_EQ(mapping::decode_trajectory(record.body)->poses[0].time, frame_time_from_ns(k));
  }
  EXPECT_EQ(gate.frames, 123u);
  EXPECT_EQ(publisher.times().count(), 100u);
  EXPECT_FALSE(failures.any());
}

// What hangs in a record is stuck; what waits for the next one is not.
TEST(Publisher, ItsHeartBeatsForEachRecordAndRestsBetween) {
  Gate gate;
  Failures failures;
  Publisher publisher({}, WhenFull::wait, gate.outbox(), failures);
  const auto later = [] { return now() + std::chrono::hours(1); };
  publisher.start();
  EXPECT_FALSE(publisher.heartbeat().stuck(later()));
  Publisher::Sealed* slot = publisher.slot();
  fill_poses(*slot, 1);
  publisher.publish(slot);
  EXPECT_TRUE(test::wait_until([&] { return publisher.heartbeat().stuck(later()); }, std::chrono::seconds(20)));
  EXPECT_FALSE(publisher.heartbeat().stuck(now())) << "it may take its time";
  gate.let_go();
  EXPECT_TRUE(test::wait_until([&] { return !publisher.heartbeat().stuck(later()); }, std::chrono::seconds(20)));
  publisher.finish(1);
  publisher.join();
  EXPECT_FALSE(publisher.heartbeat().stuck(later()));
}

TEST(Publisher, ACameraDoesNotWaitForASlot) {
  Gate gate;
  Failures failures;
  Publisher publisher({}, WhenFull::later, gate.outbox(), failures);
  publisher.start();
  int published = 0;
  for (int k = 0; k < 20; ++k) {
    Publisher::Sealed* slot = publisher.slot();
    if (slot == nullptr) break;
    fill_poses(*slot, k);
    publisher.publish(slot);
    ++published;
  }
  EXPECT_EQ(published, 4) << "the publisher is held: its slots are bounded";
  EXPECT_EQ(publisher.slot(), nullptr);
  gate.let_go();
  Publisher::Sealed* slot = publisher.awaited_slot();
  ASSERT_NE(slot, nullptr);
  publisher.give_back(slot);
  publisher.finish(1);
  publisher.join();
  EXPECT_EQ(gate.records.size(), 4u);
}

TEST(Publisher, AChainEndsBehindItsLastRecord) {
  Gate gate;
  gate.let_go();
  Failures failures;
  Publisher publisher({}, WhenFull::wait, gate.outbox(), failures);
  publisher.start();
  for (int k = 0; k < 9; ++k) {
    Publisher::Sealed* slot = publisher.slot();
    ASSERT_NE(slot, nullptr);
    fill_poses(*slot, k);
    if (k == 6) {
      slot->what = What::chain_end;
      slot->frames = 77;
    }
    publisher.publish(slot);
  }
  publisher.finish(5);
  publisher.join();
  EXPECT_EQ(gate.records.size(), 8u);
  ASSERT_EQ(gate.chains.size(), 1u);
  EXPECT_EQ(gate.chains[0], std::pair(77u, std::size_t{6}));
}

TEST(Publisher, AFrameThreadDoesNotWaitForAPublisherThatFailed) {
  Failures failures;
  Publisher publisher({}, WhenFull::wait,
                      {[](const OutgoingRecord&) { throw std::runtime_error("no more memory"); }, [](std::uint32_t) {},
                       [](std::uint32_t) {}},
                      failures);
  publisher.start();
  int slots = 0;
  while (Publisher::Sealed* slot = publisher.slot()) {
    fill_poses(*slot, slots++);
    publisher.publish(slot);
    ASSERT_LT(slots, 10);
  }
  publisher.finish(5);
  publisher.join();
  EXPECT_EQ(failures.first(), "publisher: no more memory");
}

TEST(Publisher, AllKindsOfRecordsKeepTheirLanes) {
  Gate gate;
  gate.let_go();
  Failures failures;
  Publisher publisher({}, WhenFull::wait, gate.outbox(), failures);
  publisher.start();
  for (const What what : {What::keyframe, What::poses, What::submap}) {
    Publisher::Sealed* slot = publisher.slot();
    fill_poses(*slot, 1);
    slot->what = what;
    publisher.publish(slot);
  }
  publisher.finish(0);
  publisher.join();
  ASSERT_EQ(gate.records.size(), 3u);
  EXPECT_EQ(gate.records[0].lane, mapping::Lane::features);
  EXPECT_EQ(gate.records[1].lane, mapping::Lane::poses);
  EXPECT_EQ(gate.records[2].lane, mapping::Lane::voxels);
  EXPECT_EQ(gate.records[0].poses + gate.records[2].poses, 0u);
}

}  // namespace
}  // namespace onemap::daemon
