// The simulator itself: what links, air and disks do, that a run is a function of its seed, and that what breaks is
// seen.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "comms/memory_store.hpp"
#include "sim/disk.hpp"
#include "sim/run.hpp"
#include "sim/watch.hpp"

namespace onemap::comms::sim {
namespace {
using namespace std::chrono_literals;

TEST(SimLink, LosesDelaysAndCopiesAsItsModelSays) {
  Link link(1);
  const LinkModel model{.loss = 0.2, .duplication = 0.1, .delay = 10ms, .jitter = 5ms};
  std::size_t arrived = 0;
  constexpr int kSent = 20'000;
  for (int i = 0; i < kSent; ++i) {
    const auto fate = link.send(model, Instant(1s), 100);
    arrived += fate.copies;
    for (std::size_t k = 0; k < fate.copies; ++k) {
      EXPECT_GE(fate.arrivals[k].at, Instant(1s) + 10ms);
      EXPECT_LT(fate.arrivals[k].at, Instant(1s) + 15ms);
    }
  }
  EXPECT_NEAR(static_cast<double>(arrived) / kSent, 0.8 * 1.1, 0.02);
}

TEST(SimLink, HasARateAndAQueueThatEnds) {
  Link link(2);
  const LinkModel model{.delay = 0ms, .bytes_per_second = 100'000, .queue_bytes = 10'000};
  std::size_t kept = 0;
  for (int i = 0; i < 50; ++i) {
    const auto fate = link.send(model, Instant(1s), 1000);
    if (fate.copies == 0) continue;
    ++kept;
    EXPECT_EQ(fate.arrivals[0].at, Instant(1s) + kept * 10ms);
  }
  EXPECT_EQ(kept, 11u);
}

TEST(SimLink, BurstsTakeTheirShareOfTime) {
  Link link(3);
  const LinkModel model{.burst_every = 400ms, .burst_lasts = 100ms};
  int lost = 0, turns = 0;
  bool before = false;
  constexpr int kSent = 200'000;
  for (int i = 0; i < kSent; ++i) {
    const bool gone = link.send(model, Instant(1s) + i * 1ms, 100).copies == 0;
    lost += gone, turns += gone != before, before = gone;
  }
  EXPECT_NEAR(static_cast<double>(lost) / kSent, 0.2, 0.03);
  EXPECT_LT(turns, 1000);  // in bursts: 400 of them begin and end in 200 s
}

TEST(SimLink, ClogsHoldBackUntilTheyEnd) {
  Link link(4);
  link.clog(Instant(2s));
  EXPECT_EQ(link.send({.delay = 1ms}, Instant(1s), 10).arrivals[0].at, Instant(2s) + 1ms);
  EXPECT_EQ(link.send({.delay = 1ms}, Instant(3s), 10).arrivals[0].at, Instant(3s) + 1ms);
}

TEST(SimMedium, NeighboursShareTheAirAndOthersDoNot) {
  Medium air({.bytes_per_second = 1'000'000, .overhead_bytes = 0, .patience = 1s});
  const auto near_0_and_1 = [](std::size_t who) { return who < 2; };
  const auto nobody = [](std::size_t) { return false; };
  EXPECT_EQ(air.send(Instant(1s), 0, 3, 1000, near_0_and_1), Instant(1s) + 1ms);
  EXPECT_EQ(air.send(Instant(1s), 1, 3, 1000, near_0_and_1), Instant(1s) + 2ms);
  EXPECT_EQ(air.send(Instant(1s), 2, 3, 1000, nobody), Instant(1s) + 1ms);
  while (air.send(Instant(1s), 0, 3, 1000, nobody)) continue;  // what would wait for more than a second is dropped
  EXPECT_TRUE(air.send(Instant(3s), 0, 3, 1000, nobody));
}

Record record(std::uint32_t seq, std::size_t bytes) {
  return {{{RobotId::from_name("a"), 1, 1}, seq}, 2, std::vector<std::uint8_t>(bytes, 7)};
}

TEST(SimDisk, KeepsWhatWasSyncedAndLosesATailAnywhere) {
  std::set<std::uint32_t> left;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Random random(seed);
    LogDisk disk(1u << 20, 0);
    {
      auto store = disk.open();
      for (std::uint32_t seq = 0; seq < 3; ++seq) ASSERT_TRUE(store->append(record(seq, 50)));
      ASSERT_TRUE(store->sync());
      for (std::uint32_t seq = 3; seq < 8; ++seq) ASSERT_TRUE(store->append(record(seq, 50)));
      disk.die();
    }
    disk.crash(random);
    auto store = disk.open();
    const std::uint32_t count = store->frontier().begin()->second;
    ASSERT_GE(count, 3u);
    left.insert(count);
    for (std::uint32_t seq = 0; seq < count; ++seq)
      EXPECT_EQ(store->find({record(seq, 0).id})->body, record(seq, 50).body);
    EXPECT_TRUE(store->append(record(count, 9))) << "what was cut off can be written again";
  }
  EXPECT_GE(left.size(), 5u);
}

TEST(SimField, GatheredRobotsReachEachOther) {
  Random random(5);
  Field field({.reach = 0.1, .speed = 0.1}, 12, random);
  field.drive(20s);
  field.gather();
  EXPECT_THAT(distances(12, field.edges(), 0), testing::Not(testing::Contains(-1)));
}

TEST(Simulation, IsAFunctionOfItsSeed) {
  for (const std::uint64_t seed : {3u, 8u, 21u})
    EXPECT_EQ(run(scenario_of(seed)).digest, run(scenario_of(seed)).digest);
  EXPECT_NE(run(scenario_of(3)).digest, run(scenario_of(4)).digest);
}

NodeConfig life(std::uint64_t incarnation) {
  NodeConfig out;
  out.incarnation = incarnation;
  return out;
}

// A store that loses what it promised to keep: the simulator must see it, or its other answers are worth nothing.
class Forgetful final : public NodeDisk {
 public:
  std::unique_ptr<LogStore> open() override { return std::make_unique<MemoryStore>(1u << 20); }
  void crash(Random&) override {}
  void wipe() override {}
};

TEST(Watch, SeesARecordThatWasPromisedAndIsGone) {
  SimNet net(1, {});
  Watch watch(net);
  net.add(life(5), std::make_unique<Forgetful>());
  net.append(0, 1, 20);
  net.switch_off(0);
  net.switch_on(0, 6);
  watch.came_back(0);
  EXPECT_THAT(watch.what(), testing::HasSubstr("is not on its disk"));
}

TEST(Watch, SeesASequenceNumberThatIsUsedTwice) {
  SimNet net(1, {});
  Watch watch(net);
  net.add(life(5), std::make_unique<Forgetful>());
  net.append(0, 1, 20);
  net.switch_off(0);
  net.switch_on(0, 5);
  net.append(0, 1, 20);
  EXPECT_THAT(watch.what(), testing::HasSubstr("used twice"));
}

TEST(Watch, SeesAnswersToAddressesThatProvedNothing) {
  SimNet net(1, {});
  Watch watch(net);
  net.add(life(5));
  OutgoingDatagram datagram;
  datagram.to = Endpoint::ipv4(10, 9, 9, 9, 1);
  std::array<std::uint8_t, kMaxDatagramBytes> buffer{};
  wire::Encoder out(buffer, {wire::DatagramType::unicast, 5, 0, 1});
  out.ping(1);
  std::copy_n(buffer.begin(), out.size(), datagram.buffer.begin());
  datagram.size = out.size();
  watch.sent(0, datagram);
  EXPECT_THAT(watch.what(), testing::HasSubstr("proved nothing"));
}

// Partitioned for good, a team does not become equal: that fails, and what has nothing to do with it goes.
TEST(Shrink, LeavesOnlyWhatIsNeeded) {
  Scenario scenario;
  scenario.seed = 12;
  scenario.robots = 3;
  scenario.chaos = 4s;
  scenario.links = {.loss = 0.05, .jitter = 3ms};
  scenario.faults.resize(3);
  for (Fault& fault : scenario.faults) fault.kind = Fault::Kind::clock_jump, fault.at = 1s, fault.lasts = 20ms;
  // Nobody hears anybody.
  scenario.writes = {{1s, 0, 1, 10}, {1500ms, 0, 2, 10}, {2s, 0, 3, 100}};
  ASSERT_FALSE(run(scenario).failure.empty());
  const Scenario least = shrink(scenario);
  EXPECT_TRUE(least.faults.empty());
  EXPECT_EQ(least.writes.size(), 1u);
  EXPECT_EQ(least.links.loss, 0.0);
  EXPECT_THAT(run(least).failure, testing::HasSubstr("the records are not the same"));
  EXPECT_THAT(text_of(scenario), testing::HasSubstr("seed 12: "));
}

}  // namespace
}  // namespace onemap::comms::sim
