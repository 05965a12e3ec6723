#include "mapping/team/candidates.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace onemap::mapping {
namespace {

TEST(Candidates, AreTheBestSpreadOverTheClouds) {
  std::vector<CloudPair> all;
  for (std::size_t r = 0; r < 10; ++r)
    for (std::size_t s = 0; s < 10; ++s) all.push_back({r, s, 1000 - 10 * r - s});
  const auto chosen = choose(all);
  EXPECT_EQ(chosen.size(), 32u);
  EXPECT_EQ(chosen[0], all[0]);
  EXPECT_TRUE(std::ranges::is_sorted(chosen, [](const auto& x, const auto& y) { return x.votes > y.votes; }));
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_LE(std::ranges::count(chosen, i, &CloudPair::r), 4);
    EXPECT_LE(std::ranges::count(chosen, i, &CloudPair::s), 4);
  }
  std::ranges::reverse(all);
  EXPECT_EQ(choose(all), chosen) << "the order does not show";
}

TEST(Candidates, StopEndsTheSearch) {
  const KeyframeSource source{RobotId::from_name("a"), 2, [](std::size_t) { return KeyframeRecord{}; }};
  PlaceIndexConfig config;
  config.budget_bytes = 4u << 20;
  PlaceIndex index(config);
  EXPECT_FALSE(ask_index(index, source, [] { return true; }));
  EXPECT_FALSE(match_all_pairs(source, source, [] { return true; }));
  EXPECT_TRUE(ask_index(index, source, [] { return false; }));
}

}  // namespace
}  // namespace onemap::mapping
