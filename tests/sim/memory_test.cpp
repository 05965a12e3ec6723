// What a team of Nodes takes: memory that lasts, and none on the way of a datagram.
#include <gtest/gtest.h>
#include <malloc.h>

#include <cstdio>

#include "sim/sim_net.hpp"
#include "support/count_allocations.hpp"

namespace onemap::comms::sim {
namespace {
using namespace std::chrono_literals;

std::size_t live_bytes() { return mallinfo2().uordblks; }

void write_some(SimNet& net) {
  for (std::size_t i = 0; i < net.size(); ++i)
    for (std::uint8_t lane = 0; lane < kLaneCount; ++lane) net.append(i, lane, 2000);
}

TEST(Memory, StaysWhatItIsWhileNothingNewComes) {
  SimNet net(61, {.loss = 0.1, .duplication = 0.05, .jitter = 3ms});
  net.add_team(4, ring(4));
  write_some(net);
  ASSERT_TRUE(net.run_until([&] { return net.equal(); }, 30s));
  net.run_for(60s);
  const std::size_t before = live_bytes();
  net.run_for(300s);
  printf("after five idle minutes of four robots: %+lld bytes\n",
         static_cast<long long>(live_bytes()) - static_cast<long long>(before));
  EXPECT_LE(live_bytes(), before + 4 * 4096);  // queues breathe
}

// A record costs what the store charges for it, and little beside.
TEST(Memory, GrowsByRecordsAlone) {
  SimNet net(62, {});
  net.add_team(3, complete(3));
  const auto round = [&] {
    for (int k = 0; k < 20; ++k) write_some(net), net.run_for(500ms);
    ASSERT_TRUE(net.run_until([&] { return net.equal(); }, 30s));
    for (std::size_t i = 0; i < net.size(); ++i) net[i].applied.clear();
  };
  round();
  std::size_t before = live_bytes(), charged = 0;
  for (std::size_t i = 0; i < 3; ++i) charged += net[i].store->bytes();
  const std::uint64_t allocations = test::allocations(), datagrams = net.datagrams_carried();
  round();
  std::size_t stored = 0;
  for (std::size_t i = 0; i < 3; ++i) stored += net[i].store->bytes();
  stored -= charged;
  const std::size_t grown = live_bytes() - before;
  printf("%zu bytes for records that the stores charge with %zu; %.1f allocations a datagram, of nodes and net\n",
         grown, stored,
         static_cast<double>(test::allocations() - allocations) /
             static_cast<double>(net.datagrams_carried() - datagrams));
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  EXPECT_LT(grown, stored + stored / 4);
#endif
}

}  // namespace
}  // namespace onemap::comms::sim
