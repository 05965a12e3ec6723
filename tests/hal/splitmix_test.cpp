#include "hal/base/splitmix.hpp"

#include <gtest/gtest.h>

#include <array>

namespace onemap {
namespace {

TEST(SplitMix, GivesThePublishedNumbers) {  // of the reference implementation, seed 1234567
  SplitMix random(1234567);
  for (const std::uint64_t expected :
       {6457827717110365317u, 3203168211198807973u, 9817491932198370423u, 4593380528125082431u, 16408922859458223821u})
    EXPECT_EQ(random.next(), expected);
}

TEST(SplitMix, StaysBelowAndReachesAll) {
  SplitMix random(1);
  std::array<int, 7> seen{};
  for (int i = 0; i < 700; ++i) ++seen.at(random.below(seen.size()));
  for (const int count : seen) EXPECT_GT(count, 50);
  EXPECT_EQ(random.below(1), 0u);
  EXPECT_LT(random.below(std::size_t{1} << 32), std::size_t{1} << 32);
  for (int i = 0; i < 1000; ++i) {
    const double unit = random.unit();
    EXPECT_GE(unit, 0.0);
    EXPECT_LT(unit, 1.0);
  }
}

}  // namespace
}  // namespace onemap
