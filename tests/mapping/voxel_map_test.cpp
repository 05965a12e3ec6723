#include "mapping/local/voxel_map.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <map>

#include "local/voxel_bytes.hpp"
#include "support/random.hpp"

namespace onemap::mapping {
namespace {

VoxelMapConfig small_map(std::size_t budget_bytes) {
  VoxelMapConfig config;
  config.budget_bytes = budget_bytes;
  config.image_pixels = 0;
  return config;
}

BlockKey random_key(test::Random& random, int reach) {
  const auto axis = [&] { return static_cast<std::int32_t>(random.integer(-reach, reach)); };
  return {axis(), axis(), axis()};
}

// What digest() relies on, as a machine with another order of bytes would write it.
TEST(Voxel, StandsInMemoryAsItsBytes) {
  if (!kVoxelsAreBytes) GTEST_SKIP() << "not a little-endian machine: the digest writes every voxel's bytes";
  test::Random random(4);
  std::array<Voxel, 500> voxels{};
  for (Voxel& voxel : voxels) {
    voxel.add_tsdf(static_cast<int>(random.integer(-kTsdfOne, kTsdfOne)), static_cast<int>(random.integer(1, 4000)));
    for (auto n = random.integer(0, 300); n > 0; --n) voxel.add_color(static_cast<int>(random.integer(0, 255)), 7, 200);
  }
  std::array<std::uint8_t, sizeof voxels> bytes{}, memory{};
  voxel_bytes(voxels, bytes.data());
  std::memcpy(memory.data(), voxels.data(), sizeof voxels);
  EXPECT_EQ(memory, bytes);
}

TEST(Voxel, SumsAreExactAndCommuteBelowSaturation) {
  test::Random random(1);
  std::vector<std::array<int, 5>> seen(200);
  for (auto& s : seen)
    s = {static_cast<int>(random.integer(-kTsdfOne, kTsdfOne)), static_cast<int>(random.integer(1, 16)),
         static_cast<int>(random.integer(0, 255)), static_cast<int>(random.integer(0, 255)),
         static_cast<int>(random.integer(0, 255))};
  const auto fuse = [](const auto& list) {
    Voxel voxel;
    for (const auto& s : list) {
      voxel.add_tsdf(s[0], s[1]);
      voxel.add_color(s[2], s[3], s[4]);
    }
    return voxel;
  };
  const Voxel forward = fuse(seen);
  std::int64_t sum = 0, weight = 0, red = 0;
  for (const auto& s : seen) {
    sum += s[0] * s[1];
    weight += s[1];
    red += s[2];
  }
  EXPECT_EQ(forward.tsdf_sum, sum);
  EXPECT_EQ(forward.weight, weight);
  EXPECT_EQ(forward.rgb_sum[0], red);
  EXPECT_EQ(forward.color_weight, 200u);
  std::reverse(seen.begin(), seen.end());
  EXPECT_EQ(fuse(seen), forward);
}

TEST(Voxel, KeepsItsMeanWhenItSaturates) {
  Voxel voxel;
  for (int i = 0; i < 100000; ++i) {
    voxel.add_tsdf(i % 2 == 0 ? -kTsdfOne : -kTsdfOne + 10, 16);
    voxel.add_color(255, 128, 1);
  }
  EXPECT_LE(voxel.weight, Voxel::kMaxWeight);
  EXPECT_GT(voxel.weight, Voxel::kMaxWeight / 3);
  EXPECT_NEAR(voxel.tsdf(), -995, 1);
  EXPECT_NEAR(voxel.color()[0], 255, 1);
  EXPECT_NEAR(voxel.color()[1], 128, 1);
}

TEST(Voxel, RoundsItsMeanToNearest) {
  Voxel voxel;
  voxel.add_tsdf(-3, 1);
  voxel.add_tsdf(-4, 3);  // mean -3.75
  EXPECT_EQ(voxel.tsdf(), -4);
  voxel = {};
  voxel.add_tsdf(3, 3);
  voxel.add_tsdf(4, 1);  // mean 3.25
  EXPECT_EQ(voxel.tsdf(), 3);
}

TEST(VoxelMap, AgreesWithAnOrderedMap) {
  VoxelMap map(small_map(8 << 20));
  std::map<BlockKey, int> truth;
  test::Random random(7);
  for (int i = 0; i < 5000; ++i) {
    const BlockKey key = random_key(random, 6);
    Voxel* block = map.find_or_add(key);
    if (block == nullptr) {
      EXPECT_FALSE(truth.contains(key));
      continue;
    }
    block[i % kBlockVoxels].add_tsdf(1, 1);
    ++truth[key];
  }
  EXPECT_EQ(map.used(), truth.size());
  EXPECT_EQ(map.find({100, 0, 0}), nullptr);
  auto expected = truth.begin();
  map.for_each_sorted([&](const BlockView& block) {
    ASSERT_NE(expected, truth.end());
    EXPECT_EQ(block.key, expected->first);
    int sum = 0;
    for (const Voxel& voxel : block.voxels) sum += voxel.weight;
    EXPECT_EQ(sum, expected->second);
    EXPECT_EQ(map.find(block.key), block.voxels.data());
    ++expected;
  });
  EXPECT_EQ(expected, truth.end());
}

TEST(VoxelMap, StaysInItsBudgetAndRefusesWhenFull) {
  const std::size_t budget = 1 << 20;
  VoxelMap map(small_map(budget));
  EXPECT_LE(map.bytes(), budget);
  EXPECT_GE(map.capacity(), budget / (kBlockVoxels * sizeof(Voxel)) * 9 / 10);
  const auto count = static_cast<std::int32_t>(map.capacity());
  for (std::int32_t i = 0; i < count; ++i) ASSERT_NE(map.find_or_add({i, -i, 3 * i}), nullptr);
  const Voxel* before = map.find({0, 0, 0});
  EXPECT_EQ(map.find_or_add({-1, 0, 0}), nullptr);
  EXPECT_EQ(map.counters().blocks_refused, 1u);
  EXPECT_EQ(map.find_or_add({0, 0, 0}), before);  // what is mapped stays usable
  EXPECT_EQ(map.counters().blocks_refused, 1u);
}

TEST(VoxelMap, WithoutABudgetHoldsNothing) {
  VoxelMap map(small_map(100));
  EXPECT_EQ(map.capacity(), 0u);
  EXPECT_EQ(map.find({0, 0, 0}), nullptr);
  EXPECT_EQ(map.find_or_add({0, 0, 0}), nullptr);
}

TEST(VoxelMap, DigestDependsOnContentAndNotOnArrival) {
  test::Random random(3);
  std::vector<BlockKey> keys;
  for (int i = 0; i < 60; ++i) keys.push_back({i - 30, static_cast<std::int32_t>(random.integer(-5, 5)), 2});
  const auto filled = [](const std::vector<BlockKey>& order) {
    VoxelMap map(small_map(1 << 20));
    for (const BlockKey& key : order) map.find_or_add(key)[static_cast<std::size_t>(key.x + 30)].add_tsdf(key.y, 2);
    return map.digest();
  };
  const std::uint64_t digest = filled(keys);
  std::reverse(keys.begin(), keys.end());
  EXPECT_EQ(filled(keys), digest);
  keys[5].y += 1;
  EXPECT_NE(filled(keys), digest);
}

// XXH64 of no bytes with seed 0, as its specification states.
TEST(VoxelMap, DigestOfAnEmptyMapIsXxh64OfNothing) {
  EXPECT_EQ(VoxelMap(small_map(1 << 20)).digest(), 0xEF46DB3751D8E999u);
}

TEST(VoxelMap, HandsOutChangedBlocksOnceInOrder) {
  VoxelMap map(small_map(1 << 20));
  const auto see = [&](const BlockKey& key, int from, int to, int weight = 1) {
    for (int i = from; i < to; ++i) map.find_or_add(key)[i].add_tsdf(5, weight);
  };
  for (const BlockKey& key : {BlockKey{2, 0, 0}, BlockKey{-1, 5, 0}, BlockKey{2, -1, 0}}) see(key, 0, 80);
  map.find_or_add({7, 7, 7});  // nothing was seen in it
  EXPECT_EQ(map.take_settled(0, 2), (std::vector<BlockKey>{{-1, 5, 0}, {2, -1, 0}}));
  EXPECT_EQ(map.take_settled(0, 9), (std::vector<BlockKey>{{2, 0, 0}}));
  EXPECT_TRUE(map.take_settled(0, 9).empty());
  see({-1, 5, 0}, 80, 99);
  EXPECT_TRUE(map.take_settled(0, 9).empty()) << "nineteen voxels more of eighty are not worth its bytes";
  see({-1, 5, 0}, 99, 100);
  EXPECT_EQ(map.take_settled(0, 9), (std::vector<BlockKey>{{-1, 5, 0}}));
  see({2, 0, 0}, 0, 80);
  EXPECT_TRUE(map.take_settled(0, 9).empty()) << "seen twice";
  see({2, 0, 0}, 0, 80);
  EXPECT_EQ(map.take_settled(0, 9), (std::vector<BlockKey>{{2, 0, 0}}));
  see({2, -1, 0}, 0, 1, 5);
  map.mark_handed_out();
  see({2, -1, 0}, 0, 80);
  EXPECT_TRUE(map.take_settled(0, 9).empty()) << "not thrice what was marked";
}

}  // namespace
}  // namespace onemap::mapping
