#include "local/submap_shelf.hpp"

#include <gtest/gtest.h>

#include <map>

namespace onemap::mapping {
namespace {

VoxelMapConfig small() {
  VoxelMapConfig config;
  config.budget_bytes = 2u << 20;
  config.image_pixels = 0;
  return config;
}

// So many blocks in a row, a few voxels seen in each.
VoxelMap row(int blocks, int value) {
  VoxelMap map(small());
  for (int i = 0; i < blocks; ++i) {
    Voxel* voxels = map.find_or_add({i - 3, 2, -i});
    for (int v = 0; v < 40; ++v) {
      voxels[7 * v].add_tsdf(value - v, 3);
      voxels[7 * v].add_color(v, 10, value);
      voxels[7 * v].add_color(v, 10, value);
    }
  }
  return map;
}

std::map<std::uint32_t, std::size_t> content(const SubmapShelf& shelf) {
  std::map<std::uint32_t, std::size_t> out;
  VoxelMap scratch(small());
  shelf.for_each(scratch, [&](const SubmapAnchor& a, const VoxelMap& voxels) { out[a.keyframe] = voxels.used(); });
  return out;
}

TEST(SubmapShelf, GivesBackTheMeansAndTheWeights) {
  SubmapShelf shelf(1 << 20);
  VoxelMap map = row(5, 100), back(small());
  ASSERT_TRUE(shelf.put({7, {}}, map));
  EXPECT_TRUE(shelf.has(7));
  EXPECT_EQ(shelf.blocks(7), 5u);
  ASSERT_TRUE(shelf.take(7, back));
  EXPECT_EQ(back.digest(), map.digest());
  EXPECT_TRUE(back.take_settled(0, 100).empty()) << "all of it had been handed out";
  EXPECT_FALSE(shelf.has(7));
  EXPECT_FALSE(shelf.take(7, back));
}

TEST(SubmapShelf, HeavyVoxelsKeepTheirMeanAndARecordsWeight) {
  SubmapShelf shelf(1 << 20);
  VoxelMap map(small()), back(small());
  for (int i = 0; i < 500; ++i) map.find_or_add({})[3].add_tsdf(-640, 2);
  ASSERT_TRUE(shelf.put({0, {}}, map));
  ASSERT_TRUE(shelf.take(0, back));
  EXPECT_EQ(back.find({})[3].weight, 255);
  EXPECT_EQ(back.find({})[3].tsdf(), -640);
}

// Random puts and takes against a plain list: the oldest go, and only for want of room.
TEST(SubmapShelf, AFullShelfDropsTheOldest) {
  const std::size_t one_block = 12 + 64 + 40 * 7;
  SubmapShelf shelf(20 * one_block);
  for (std::uint32_t n = 0; n < 200; ++n) {
    const int blocks = 1 + static_cast<int>(n * 7 % 6);
    ASSERT_TRUE(shelf.put({n, {}}, row(blocks, static_cast<int>(n))));
    const auto held = content(shelf);
    ASSERT_TRUE(held.contains(n));
    std::size_t total = 0;
    for (const auto& [anchor, used] : held) {
      EXPECT_EQ(used, 1 + anchor * 7 % 6);
      EXPECT_GT(anchor + 20, n);
      total += used;
    }
    EXPECT_LE(total, 20u);
    if (n > 20) {
      EXPECT_GE(total, 9u) << "it drops no more than it must";
    }
    VoxelMap back(small());
    if (n % 5 == 4 && held.contains(n - 1)) {
      EXPECT_TRUE(shelf.take(n - 1, back));
    }
  }
  EXPECT_GT(shelf.dropped(), 100u);
  EXPECT_FALSE(shelf.put({999, {}}, row(21, 5))) << "larger than the shelf";
}

}  // namespace
}  // namespace onemap::mapping
