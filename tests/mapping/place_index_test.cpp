#include "mapping/team/place_index.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/random.hpp"
#include "team/place_search.hpp"

namespace onemap::mapping {
namespace {

using test::Random;
using Features = std::vector<BinaryFeature>;
constexpr DescriptorKind kSurf = DescriptorKind::surf_bits;
constexpr std::size_t kSmall = 4u << 20;

PlaceId id(const std::string& robot, std::uint32_t keyframe) { return {RobotId::from_name(robot), 1, keyframe}; }

Features random_features(Random& random, std::size_t count) {
  Features out(count);
  for (BinaryFeature& f : out) {
    for (auto& word : f.bits) word = random.next();
    f.laplacian = static_cast<std::int32_t>(2 * random.integer(0, 1) - 1);
  }
  return out;
}

// The same place seen again: of each feature up to so many bits differ.
Features seen_again(const Features& features, Random& random, int flips) {
  Features out = features;
  for (BinaryFeature& f : out)
    for (int i = 0; i < flips; ++i) {
      const auto bit = static_cast<std::size_t>(random.integer(0, 255));
      f.bits[bit / 64] ^= std::uint64_t{1} << (bit % 64);
    }
  return out;
}

PlaceIndexConfig small() {
  PlaceIndexConfig config;
  config.budget_bytes = kSmall;
  return config;
}

// The definition: all features of all keyframes, those that share the bits of one table with the query.
std::vector<Place> slow_query(const std::vector<std::pair<PlaceId, Features>>& held, const Features& query,
                              std::int32_t max_distance) {
  std::vector<Place> out;
  for (const auto& [id, features] : held) out.push_back({id, 0, 0});
  for (const BinaryFeature& f : query) {
    std::vector<std::pair<std::size_t, std::int32_t>> near;
    for (std::size_t k = 0; k < held.size(); ++k) {
      std::int32_t best = max_distance + 1;
      for (const BinaryFeature& g : held[k].second) {
        bool found = false;
        for (std::size_t t = 0; t < 8; ++t) found |= ((f.bits[t / 4] ^ g.bits[t / 4]) >> (16 * (t % 4)) & 0xFFFF) == 0;
        if (found && f.laplacian == g.laplacian) best = std::min(best, hamming_distance(f.bits, g.bits));
      }
      if (best <= max_distance) near.emplace_back(k, best);
    }
    const auto rarity = static_cast<std::uint64_t>(place::log2_fixed(2 * held.size() + 2)) -
                        static_cast<std::uint64_t>(place::log2_fixed(2 * near.size() + 1));
    for (const auto& [k, d] : near) {
      out[k].votes += rarity * static_cast<std::uint64_t>(max_distance + 1 - d);
      ++out[k].features;
    }
  }
  std::erase_if(out, [](const Place& place) { return place.votes == 0; });
  std::ranges::sort(out,
                    [](const Place& x, const Place& y) { return std::pair(y.votes, x.id) < std::pair(x.votes, y.id); });
  return out;
}

struct PlaceIndexTest : testing::Test {
  PlaceIndexTest() {
    for (std::uint32_t k = 0; k < 12; ++k)
      held.emplace_back(id(k % 2 == 0 ? "a" : "b", k), random_features(random, 60));
    for (std::uint32_t k = 12; k < 24; ++k)  // the same twelve places, seen by others
      held.emplace_back(id("c", k), seen_again(held[k - 12].second, random, 20));
  }
  void fill(PlaceIndex& index) {
    for (const auto& [id, features] : held) ASSERT_TRUE(index.insert(id, kSurf, features));
  }
  Random random{7};
  std::vector<std::pair<PlaceId, Features>> held;
};

TEST_F(PlaceIndexTest, EqualsTheSlowDefinition) {
  for (const bool simd : {false, true}) {
    PlaceIndexConfig config = small();
    config.simd = simd;
    PlaceIndex index(config);
    fill(index);
    ASSERT_EQ(index.table_bits(), 16u);
    for (const int flips : {0, 5, 25}) {
      const Features query = seen_again(held[3].second, random, flips);
      const auto found = index.query(kSurf, query, 100);
      EXPECT_EQ(found, slow_query(held, query, config.max_distance)) << flips;
      ASSERT_GE(found.size(), 2u);
      EXPECT_EQ(std::min(found[0].id, found[1].id), held[3].first);
      EXPECT_EQ(std::max(found[0].id, found[1].id), held[15].first);
    }
  }
}

TEST_F(PlaceIndexTest, TheOrderOfArrivalDoesNotShow) {
  PlaceIndex one(small()), other(small());
  fill(one);
  std::ranges::reverse(held);
  fill(other);
  for (const auto& [id, features] : held) EXPECT_EQ(one.query(kSurf, features, 5), other.query(kSurf, features, 5));
}

TEST_F(PlaceIndexTest, TiesGoByChainThenKeyframe) {
  PlaceIndex index(small());
  const Features same = held[0].second;
  for (const PlaceId& i : {id("b", 2), id("a", 9), id("b", 1), id("a", 10)}) ASSERT_TRUE(index.insert(i, kSurf, same));
  const auto found = index.query(kSurf, same, 3);
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(found[0].id, id("a", 9));
  EXPECT_EQ(found[1].id, id("a", 10));
  EXPECT_EQ(found[2].id, id("b", 1));
  EXPECT_EQ(found[0].votes, found[2].votes);
  EXPECT_EQ(found[0].features, 60u);
}

TEST_F(PlaceIndexTest, OnlyWhatPassesTheFilterTakesPart) {
  PlaceIndex index(small()), alone(small());
  fill(index);
  for (const auto& [id, features] : held)
    if (id.robot == RobotId::from_name("c")) alone.insert(id, kSurf, features);
  const auto of_c = [](const PlaceId& id) { return id.robot == RobotId::from_name("c"); };
  EXPECT_EQ(index.query(kSurf, held[3].second, 9, of_c), alone.query(kSurf, held[3].second, 9));
  EXPECT_TRUE(index.query(DescriptorKind::orb, held[3].second, 9).empty()) << "kinds do not mix";
}

TEST_F(PlaceIndexTest, TheLaplacianDividesFeatures) {
  PlaceIndex index(small());
  fill(index);
  Features inverted = held[3].second;
  for (BinaryFeature& f : inverted) f.laplacian = -f.laplacian;
  EXPECT_TRUE(index.query(kSurf, inverted, 9).empty());
}

TEST_F(PlaceIndexTest, WhatIsRemovedIsAsIfItHadNeverBeen) {
  PlaceIndex index(small()), fresh(small());
  fill(index);
  for (std::size_t i = 0; i < held.size(); ++i) {
    if (i % 3 == 0)
      EXPECT_TRUE(index.remove(held[i].first));
    else
      fresh.insert(held[i].first, kSurf, held[i].second);
  }
  EXPECT_FALSE(index.remove(held[0].first)) << "it is gone";
  EXPECT_EQ(index.used(), fresh.used());
  EXPECT_EQ(index.keyframes(), fresh.keyframes());
  for (const auto& [id, features] : held) EXPECT_EQ(index.query(kSurf, features, 9), fresh.query(kSurf, features, 9));
  fresh.insert(held[0].first, kSurf, held[0].second);
  EXPECT_TRUE(index.insert(held[0].first, kSurf, held[0].second)) << "and may come again";
  EXPECT_EQ(index.query(kSurf, held[0].second, 9), fresh.query(kSurf, held[0].second, 9));
  index.clear();
  EXPECT_EQ(index.used(), 0u);
  EXPECT_TRUE(index.query(kSurf, held[1].second, 9).empty());
}

TEST_F(PlaceIndexTest, RefusesWhatItHasNoRoomFor) {
  PlaceIndex index(small());
  EXPECT_LE(index.bytes(), kSmall);
  EXPECT_GT(index.capacity(), 10'000u);
  const Features many = random_features(random, 1000);
  std::uint32_t n = 0;
  while (index.insert(id("a", n), kSurf, many)) ++n;
  EXPECT_EQ(n, index.capacity() / 1000);
  EXPECT_EQ(index.refused(), 1u);
  EXPECT_FALSE(index.insert(id("a", 0), kSurf, {})) << "it is there";
  EXPECT_EQ(index.refused(), 2u);
  EXPECT_EQ(index.keyframes(), n) << "a refusal changes nothing";
  EXPECT_TRUE(index.remove(id("a", 3)));
  EXPECT_TRUE(index.insert(id("b", 0), kSurf, many));
}

TEST_F(PlaceIndexTest, KeyframesWithoutFeaturesAreBoundedToo) {
  PlaceIndex index(small());
  for (std::uint32_t n = 0; n < 100'000 && index.insert(id("a", n), kSurf, {}); ++n) {
  }
  EXPECT_LE(index.keyframes(), index.capacity() / 64);
  EXPECT_EQ(index.refused(), 1u);
}

// A wall whose features are all alike: a bucket stays small, and who stays in it is not who came first.
TEST_F(PlaceIndexTest, ADullWallFillsNoBucket) {
  std::vector<std::pair<PlaceId, Features>> wall;
  for (std::uint32_t k = 0; k < 20; ++k) {
    Features dull = random_features(random, 50);
    for (BinaryFeature& f : dull) f.bits[0] = 0x1234567890ABCDEF, f.laplacian = 1;
    wall.emplace_back(id("a", k), dull);
  }
  PlaceIndex one(small()), other(small());
  for (const auto& [id, features] : wall) one.insert(id, kSurf, features);
  for (auto k = wall.rbegin(); k != wall.rend(); ++k) other.insert(k->first, kSurf, k->second);
  EXPECT_GE(one.crowded_out(), 4 * (1000u - PlaceIndex::kMaxBucket));
  Features query = wall[0].second;
  for (BinaryFeature& f : query) f.bits[1] ^= 0x0001000100010001;  // found by the first four tables alone
  const auto found = one.query(kSurf, query, 100);
  EXPECT_FALSE(found.empty());
  EXPECT_EQ(found, other.query(kSurf, query, 100));
}

TEST_F(PlaceIndexTest, ALargeBudgetHasLongCodes) {
  PlaceIndexConfig config;
  config.budget_bytes = 160u << 20;
  PlaceIndex index(config);
  EXPECT_EQ(index.table_bits(), 20u);
  EXPECT_LE(index.bytes(), config.budget_bytes);
  EXPECT_GT(index.capacity(), 1u << 20);
  fill(index);
  const auto found = index.query(kSurf, seen_again(held[5].second, random, 10), 2);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].id, held[5].first);
}

TEST(PlaceSearch, LogarithmsAreOfTwoIn1024ths) {
  EXPECT_EQ(place::log2_fixed(1), 0u);
  EXPECT_EQ(place::log2_fixed(2), 1024u);
  EXPECT_EQ(place::log2_fixed(std::uint64_t{1} << 40), 40u * 1024);
  for (std::uint64_t x = 1; x < 3'000'000; x = x * 5 / 4 + 1)
    EXPECT_NEAR(place::log2_fixed(x), 1024 * std::log2(static_cast<double>(x)), 1.01) << x;
}

}  // namespace
}  // namespace onemap::mapping
