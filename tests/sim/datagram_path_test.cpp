// What deals with datagrams takes no memory from the heap: two robots, in the open and with a team's key, one wire.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <memory>
#include <utility>

#include "comms/guard.hpp"
#include "comms/memory_store.hpp"
#include "sim/sim_net.hpp"
#include "support/count_allocations.hpp"
#include "support/random.hpp"

namespace onemap::comms::sim {
namespace {
using namespace std::chrono_literals;

// Two robots that hear each other at once. What passes between them costs nothing here, so that what is counted is
// theirs.
class Pair {
 public:
  explicit Pair(bool sealed) {
    for (std::size_t i = 0; i < 2; ++i) {
      Robot& robot = robots_[i];
      robot.config.self = numbered("robot", i);
      robot.config.peers = {SimNet::address(1 - i)};
      robot.config.sealed = sealed;
      robot.store = std::make_unique<MemoryStore>(64u << 20);
      robot.start(i);
    }
  }
  RecordId append(std::uint8_t lane, std::size_t bytes) {
    std::vector<std::uint8_t> body(bytes);
    for (auto& byte : body) byte = static_cast<std::uint8_t>(random_.next() >> 56);
    return robots_[0].node->append(now_, lane, 1, std::move(body)).value();
  }
  void run_for(Duration time) {
    for (const Instant end = now_ + time; now_ < end; now_ += 1ms) step();
  }
  void hear_garbage() {
    std::array<std::uint8_t, 300> bytes{};
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random_.next() >> 56);
    bytes[0] = garbage_++ % 2 == 0 ? 0xB1 : 0xB2;  // as if it was ours
    bytes[1] %= 10;
    robots_[1].on_datagram(now_, SimNet::address(random_.below(2) == 0 ? 0 : 9), bytes);
  }
  const Node& node(std::size_t i) const { return *robots_[i].node; }
  std::uint64_t datagrams() const { return robots_[1].counters().datagrams_received; }
  std::uint32_t held(const LogId& log) const {
    const auto at = node(1).frontier().find(log);
    return at == node(1).frontier().end() ? 0 : at->second;
  }
  LogId log(std::uint8_t lane) const { return {robots_[0].config.self, lane, robots_[0].config.incarnation}; }
  std::uint64_t records() const { return node(1).counters().records_received; }

 private:
  void step() {
    for (std::size_t i = 0; i < 2; ++i) {
      Robot& robot = robots_[i];
      if (robot.next_deadline() <= now_) robot.on_timer(now_);
      OutgoingDatagram datagram;
      while (robot.next_outgoing(datagram))
        if (datagram.to == SimNet::address(1 - i))
          robots_[1 - i].on_datagram(now_, SimNet::address(i), datagram.bytes());
      std::shared_ptr<const Record> record;
      while (robot.node->next_applied(record)) record.reset();
    }
  }
  std::array<Robot, 2> robots_;
  Random random_{3};
  Instant now_{1s};
  unsigned garbage_ = 0;
};

struct Counted {
  std::uint64_t allocations = 0, datagrams = 0, records = 0;
};

template <class Do>
Counted counted(Pair& pair, Do what) {
  const std::uint64_t datagrams = pair.datagrams(), records = pair.records(), before = test::allocations();
  what();
  return {test::allocations() - before, pair.datagrams() - datagrams, pair.records() - records};
}

class DatagramPath : public testing::TestWithParam<bool> {};

TEST_P(DatagramPath, TakesNothingFromTheHeap) {
  Pair pair(GetParam());
  pair.append(3, 1000);
  pair.run_for(5s);
  ASSERT_EQ(pair.held(pair.log(3)), 1u);

  const Counted idle = counted(pair, [&] { pair.run_for(60s); });
  EXPECT_GT(idle.datagrams, 10u);
  EXPECT_EQ(idle.allocations, 0u);

  // A record that is on its way: 900 fragments, and not all of them yet.
  pair.append(3, 1'000'000);
  pair.run_for(20ms);
  const Counted parts = counted(pair, [&] { pair.run_for(80ms); });
  ASSERT_EQ(pair.held(pair.log(3)), 1u) << "it is too soon for all of it";
  EXPECT_GT(parts.datagrams, 20u);
  EXPECT_EQ(parts.allocations, 0u);
  pair.run_for(60s);
  ASSERT_EQ(pair.held(pair.log(3)), 2u);

  const Counted garbage = counted(pair, [&] {
    for (int k = 0; k < 20'000; ++k) pair.hear_garbage();
    pair.run_for(1s);
  });
  EXPECT_GE(garbage.datagrams, 20'000u);
  EXPECT_EQ(garbage.allocations, 0u);
  EXPECT_EQ(pair.node(1).memory_view().spilled, 0u);
}

// Of a record that is whole there is what the store keeps of it: its body, itself, and now and then room in a list.
TEST_P(DatagramPath, ARecordIsWhatTheStoreKeeps) {
  Pair pair(GetParam());
  for (int k = 0; k < 100; ++k) pair.append(1, 120), pair.append(3, 3000), pair.run_for(50ms);
  pair.run_for(5s);
  std::uint64_t own = 0;
  const Counted all = counted(pair, [&] {
    for (int k = 0; k < 200; ++k) {
      const std::uint64_t before = test::allocations();
      pair.append(1, 120), pair.append(3, 3000);
      own += test::allocations() - before;
      pair.run_for(50ms);
    }
    pair.run_for(5s);
  });
  ASSERT_EQ(all.records, 400u);
  const double a_record = static_cast<double>(all.allocations - own) / static_cast<double>(all.records);
  std::printf("%.2f allocations a record that came, in %.2f datagrams; %.2f a record that was written\n", a_record,
              static_cast<double>(all.datagrams) / static_cast<double>(all.records), static_cast<double>(own) / 400);
  EXPECT_LE(a_record, 2.1);
  EXPECT_LE(own, 2.1 * 400);
  EXPECT_EQ(pair.node(0).memory_view().spilled + pair.node(1).memory_view().spilled, 0u);
}

INSTANTIATE_TEST_SUITE_P(Of, DatagramPath, testing::Bool(),
                         [](const auto& sealed) { return sealed.param ? "ATeamWithAKey" : "AnOpenTeam"; });

}  // namespace
}  // namespace onemap::comms::sim
