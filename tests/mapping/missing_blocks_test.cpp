#include "mapping/local/missing_blocks.hpp"

#include <gtest/gtest.h>

#include <set>

#include "support/random.hpp"

namespace onemap::mapping {
namespace {

TEST(MissingBlocks, NotesEachBlockOnceAFrame) {
  MissingBlocks missing(300);
  test::Random random(5);
  for (int frame = 0; frame < 4; ++frame) {
    std::set<BlockKey> truth;
    missing.begin_frame();
    for (int i = 0; i < 1000; ++i) {
      const auto axis = [&] { return static_cast<std::int32_t>(random.integer(-3, 3)); };
      const BlockKey key{axis(), axis(), axis()};
      if (truth.size() == 300 && !truth.contains(key)) continue;
      EXPECT_EQ(missing.add(key), truth.insert(key).second);
    }
    EXPECT_EQ(missing.count(), truth.size());
  }
}

TEST(MissingBlocks, MoreThanItHoldsAreNotNoted) {
  MissingBlocks missing(2);
  EXPECT_TRUE(missing.add({1, 0, 0}));
  EXPECT_TRUE(missing.add({2, 0, 0}));
  EXPECT_FALSE(missing.add({3, 0, 0}));
  EXPECT_FALSE(missing.add({1, 0, 0}));
  EXPECT_EQ(missing.count(), 2u);
  EXPECT_FALSE(MissingBlocks(0).add({}));
}

}  // namespace
}  // namespace onemap::mapping
