// A hundred robots at their daily work. How much faster than life that is, onemap_sim --explore prints.
#include "sim/explore.hpp"

#include <gtest/gtest.h>

#include <cstdio>

#include "sim/signatures.hpp"

namespace onemap::comms::sim {
namespace {
using namespace std::chrono_literals;

TEST(Explore, AHundredRobotsKnowAllOfEachOther) {
  const RememberSignatures remember;
  Exploring team;
  team.lasts = 10s;
  const Explored all = explore(team, 1);
  EXPECT_TRUE(all.equal);
  EXPECT_EQ(all.records, 100u);
  EXPECT_LE(all.to_equal, 500ms);
  const double each = static_cast<double>(all.bytes) / 100 / to_seconds(all.simulated);
  std::printf("%.0f bytes/s a robot, %llu datagrams; %.1f times real time\n", each,
              static_cast<unsigned long long>(all.datagrams), to_seconds(all.simulated) / all.real_s);
  EXPECT_LE(each, 33'000) << "ten neighbours, and beacons as for four";
}

}  // namespace
}  // namespace onemap::comms::sim
