#include "mapping/team/patience.hpp"

#include <gtest/gtest.h>

namespace onemap::mapping {
namespace {

using namespace std::chrono_literals;
constexpr Instant kStart{};

TEST(Patience, EndsAfterWaitingWithoutABreak) {
  Patience<int> patience(10s);
  EXPECT_FALSE(patience.exhausted(1, true, kStart));
  EXPECT_FALSE(patience.exhausted(2, true, kStart + 8s));
  EXPECT_FALSE(patience.exhausted(1, true, kStart + 10s));
  EXPECT_TRUE(patience.exhausted(1, true, kStart + 11s));
  EXPECT_FALSE(patience.exhausted(2, true, kStart + 11s)) << "each thing by itself";
  EXPECT_FALSE(patience.exhausted(1, false, kStart + 12s));
  EXPECT_FALSE(patience.exhausted(1, true, kStart + 13s)) << "begins anew";
  EXPECT_TRUE(patience.exhausted(1, true, kStart + 24s));
  patience.reset();
  EXPECT_FALSE(patience.exhausted(1, true, kStart + 25s));
}

}  // namespace
}  // namespace onemap::mapping
