#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <string>

#include "sim_net.hpp"

namespace onemap::comms {
namespace {
using namespace std::chrono_literals;
using sim::Edge;
using sim::LinkModel;
using sim::SimNet;

// Every robot holds what every robot wrote, body by body, given out once each and in log order.
void expect_same_records(SimNet& net) {
  for (std::size_t i = 1; i < net.size(); ++i) {
    ASSERT_EQ(net.node(i).frontier(), net.node(0).frontier()) << "robot " << i;
    EXPECT_EQ(net.node(i).frontier_digest(), digest(net.node(0).frontier()));
  }
  for (std::size_t i = 0; i < net.size(); ++i) {
    VersionVector seen;
    for (const auto& record : net[i].applied) {
      EXPECT_EQ(record->id.seq, seen[record->id.log]++);
      const auto original = net[0].store->find(record->id);
      ASSERT_NE(original, nullptr);
      EXPECT_EQ(record->kind, original->kind);
      EXPECT_EQ(record->body, original->body);
    }
    EXPECT_EQ(seen, net.node(i).frontier());
  }
}

void write_some(SimNet& net, std::size_t robot) {
  for (int k = 0; k < 10; ++k) net.append(robot, 1, 300, 3);
  for (int k = 0; k < 4; ++k) net.append(robot, 2, 20'000, 2);
  net.append(robot, 3, 150'000, 4);
  net.append(robot, 0, 0, 7);  // an empty body is a record, too
}

struct Shape {
  const char* name;
  std::vector<Edge> (*edges)(std::size_t);
};
constexpr Shape kShapes[] = {
    {"complete", sim::complete}, {"line", sim::line}, {"ring", sim::ring}, {"star", sim::star}};

TEST(Replication, ConvergesOnEveryGraphAtEveryLoss) {
  for (const Shape& shape : kShapes)
    for (const double loss : {0.0, 0.1, 0.2, 0.3}) {
      double seconds = 0.0, overhead = 0.0;
      for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        SimNet net(seed, {.loss = loss, .duplication = 0.02, .delay = 5ms, .jitter = 4ms});
        net.add_team(5, shape.edges(5));
        for (std::size_t i = 0; i < 5; ++i) write_some(net, i);
        const Instant start = net.now();
        ASSERT_TRUE(net.run_until([&] { return net.equal(); }, 60s))
            << shape.name << " loss " << loss << " seed " << seed;
        seconds += to_seconds(net.now() - start) / 5;
        overhead += static_cast<double>(net.bytes_carried()) / static_cast<double>(4 * net.useful_bytes()) / 5;
        net.run_for(5s);
        expect_same_records(net);
        EXPECT_LE(net.largest_datagram(), kMaxDatagramBytes);
      }
      printf("%-9s loss %2.0f %%: %.2f s to equal, sent / useful %.3f\n", shape.name, loss * 100, seconds, overhead);
      EXPECT_LE(overhead, 1.3 / (1.0 - loss)) << shape.name << " loss " << loss;
    }
}

}  // namespace
}  // namespace onemap::comms
