// The block of memory in which a node lives.
#include "memory/arena.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <vector>

#include "memory/log_map.hpp"
#include "support/random.hpp"

namespace onemap::comms {
namespace {

struct Piece {
  unsigned char* at;
  std::size_t bytes;
  unsigned char mark;
};

bool is_marked(const Piece& piece) {
  return std::all_of(piece.at, piece.at + piece.bytes, [&](unsigned char byte) { return byte == piece.mark; });
}

Piece take(Arena& arena, std::size_t bytes, unsigned char mark) {
  auto* const at = static_cast<unsigned char*>(arena.allocate(bytes));
  std::fill_n(at, bytes, mark);
  return {at, bytes, mark};
}

// Small ones, some larger ones, and now and then a record.
std::size_t some_size(Random& random) {
  const auto kind = random.below(20);
  return 1 + random.below(kind == 0 ? 60'000 : kind < 5 ? 2'000 : 100);
}

TEST(Arena, PiecesAreApartAndAlignedAndComeBackWhole) {
  Arena arena(1u << 20);
  Random random(5);
  std::vector<Piece> pieces;
  for (int step = 0; step < 100'000; ++step) {
    const bool takes = pieces.empty() || (random.below(2) == 0 && arena.used() < 600'000);
    if (takes) {
      pieces.push_back(take(arena, some_size(random), static_cast<unsigned char>(step)));
      ASSERT_EQ(reinterpret_cast<std::uintptr_t>(pieces.back().at) % alignof(std::max_align_t), 0u);
      continue;
    }
    std::swap(pieces[random.below(pieces.size())], pieces.back());
    ASSERT_TRUE(is_marked(pieces.back())) << "step " << step;
    arena.deallocate(pieces.back().at, pieces.back().bytes);
    pieces.pop_back();
  }
  EXPECT_EQ(arena.spilled(), 0u);
  for (const Piece& piece : pieces) arena.deallocate(piece.at, piece.bytes);
  EXPECT_EQ(arena.used(), 0u);
  EXPECT_GE(arena.most_used(), 500'000u);
  const std::size_t nearly_all = arena.capacity() / 16 * 15;  // all that was free is one block again
  arena.deallocate(arena.allocate(nearly_all), nearly_all);
  EXPECT_EQ(arena.spilled(), 0u);
}

TEST(Arena, APieceTakesEightBytesBesideItself) {
  Arena arena(1u << 16, true);
  void* const least = arena.allocate(1);
  EXPECT_EQ(arena.used(), 16u);
  void* const exact = arena.allocate(24);
  EXPECT_EQ(arena.used(), 16u + 32u);
  arena.deallocate(least, 1);
  arena.deallocate(exact, 24);
}

TEST(Arena, WhatDoesNotFitComesFromTheHeapAndIsCounted) {
  Arena arena(1u << 16);
  const Piece large = take(arena, 100'000, 1), within = take(arena, 1000, 2);
  EXPECT_EQ(arena.spilled(), 1u);
  void* const wide = arena.allocate(64, 64);
  EXPECT_EQ(arena.spilled(), 2u);
  EXPECT_LT(arena.used(), 1100u);
  EXPECT_TRUE(is_marked(large));
  arena.deallocate(large.at, large.bytes);
  arena.deallocate(within.at, within.bytes);
  arena.deallocate(wide, 64, 64);
  EXPECT_EQ(arena.used(), 0u);
}

TEST(Arena, OfNoMemoryThereIsNone) { EXPECT_THROW(Arena(16), std::bad_alloc); }

TEST(LogMap, FindsWhatAMapFinds) {
  Arena arena(1u << 20);
  Random random(9);
  LogMap<std::uint32_t> map(arena);
  std::map<LogId, std::uint32_t> plain;
  const auto some_log = [&] {
    return LogId{RobotId::from_name("robot" + std::to_string(random.below(40))),
                 static_cast<std::uint8_t>(random.below(kLaneCount)), 1 + random.below(10)};
  };
  EXPECT_EQ(map.find(some_log()), nullptr);
  for (std::uint32_t step = 0; step < 5000; ++step) {
    const LogId log = some_log();
    map[log] = plain[log] = step;
    const LogId other = some_log();
    const auto at = plain.find(other);
    ASSERT_EQ(map.find(other) == nullptr, at == plain.end());
    if (at == plain.end()) continue;
    EXPECT_EQ(*map.find(other), at->second);
  }
  EXPECT_EQ(map.size(), plain.size());
  EXPECT_TRUE(std::ranges::all_of(map, [&](const auto& entry) { return plain.at(entry.first) == entry.second; }));
  map.clear();
  EXPECT_EQ(map.size(), 0u);
  EXPECT_EQ(map.find(plain.begin()->first), nullptr);
}

}  // namespace
}  // namespace onemap::comms
