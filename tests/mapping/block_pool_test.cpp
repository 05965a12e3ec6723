#include "mapping/local/block_pool.hpp"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <vector>

namespace onemap::mapping {
namespace {

constexpr std::size_t kBlocks = 2000;

// How many of the pages of these blocks are in memory.
std::size_t pages_here(BlockPool& pool, std::int32_t first, std::int32_t end) {
  const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
  const auto from = reinterpret_cast<std::uintptr_t>(pool.voxels(first)) / page * page;
  const std::size_t pages = (reinterpret_cast<std::uintptr_t>(pool.voxels(end)) - from) / page;
  std::vector<unsigned char> here(pages);
  if (mincore(reinterpret_cast<void*>(from), pages * page, here.data()) != 0) return 0;
  return static_cast<std::size_t>(std::ranges::count_if(here, [](unsigned char at) { return (at & 1) != 0; }));
}

std::vector<std::int32_t> take_all(BlockPool& pool) {
  std::vector<std::int32_t> taken;
  for (std::int32_t block = pool.take(); block >= 0; block = pool.take()) {
    std::memset(static_cast<void*>(pool.voxels(block)), 0x5A, kBlockVoxels * sizeof(Voxel));
    taken.push_back(block);
  }
  std::ranges::sort(taken);
  return taken;
}

bool is(const BlockPool& pool, std::int32_t block, unsigned char byte) {
  const auto* bytes = reinterpret_cast<const unsigned char*>(pool.voxels(block));
  return std::all_of(bytes, bytes + kBlockVoxels * sizeof(Voxel), [&](unsigned char b) { return b == byte; });
}

TEST(BlockPool, WhatIsFreeAgainIsUnseenAndItsPagesGoBackToTheSystem) {
  BlockPool pool(kBlocks, false);
  ASSERT_EQ(take_all(pool).size(), kBlocks);
  const std::size_t before = pages_here(pool, 500, 1500);
  for (std::int32_t block = 500; block < 1500; ++block)
    if (block != 1000) pool.give_back(block);
  pool.give_back_pages();
  EXPECT_GT(before, 990u);
  EXPECT_LT(pages_here(pool, 500, 1500), before / 100) << "but for those of the block in the middle, and the edges'";
  for (const std::int32_t block : {499, 1000, 1500}) EXPECT_TRUE(is(pool, block, 0x5A)) << block;
  for (int i = 0; i < 999; ++i) {
    const std::int32_t block = pool.take();
    ASSERT_TRUE(block >= 500 && block < 1500 && block != 1000);
    ASSERT_TRUE(is(pool, block, 0)) << block;
  }
  EXPECT_EQ(pool.take(), -1);
}

TEST(BlockPool, AFewFreeBlocksKeepTheirPages) {
  BlockPool pool(kBlocks, false);
  take_all(pool);
  for (std::int32_t block = 0; block < 60; ++block) pool.give_back(block);
  const std::size_t before = pages_here(pool, 0, 60);
  pool.give_back_pages();
  EXPECT_EQ(pages_here(pool, 0, 60), before);
  for (std::int32_t block = 60; block < 300; ++block) pool.give_back(block);
  pool.give_back_pages();
  EXPECT_LE(pages_here(pool, 0, 300), 2u);
}

// Those in use stay together, however blocks come and go, or each page would hold a part of one.
TEST(BlockPool, TheLowestFreeOneIsTaken) {
  BlockPool pool(kBlocks, false);
  for (std::int32_t block = 0; block < 100; ++block) EXPECT_EQ(pool.take(), block);
  for (const std::int32_t block : {70, 3, 99, 41}) pool.give_back(block);
  for (const std::int32_t block : {3, 41, 70, 99, 100}) EXPECT_EQ(pool.take(), block);
}

TEST(BlockPool, AResidentOneKeepsThemAll) {
  BlockPool pool(kBlocks, true);
  const std::vector<std::int32_t> taken = take_all(pool);
  for (const std::int32_t block : taken) pool.give_back(block);
  const std::size_t before = pages_here(pool, 0, kBlocks - 1);
  pool.give_back_pages();
  EXPECT_EQ(pages_here(pool, 0, kBlocks - 1), before);
  EXPECT_TRUE(is(pool, pool.take(), 0));
}

}  // namespace
}  // namespace onemap::mapping
