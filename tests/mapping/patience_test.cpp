#include "mapping/team/patience.hpp"

#include <gtest/gtest.h>

namespace onemap::mapping {
namespace {

using namespace std::chrono_literals;
constexpr Instant kPatienceStart{};

TEST(Patience, EndsAfterWaitingWithoutABreak) {
  Patience<int> patience(10s);
  EXPECT_FALSE(patience.exhausted(1, true, kPatienceStart));
  EXPECT_FALSE(patience.exhausted(2, true, kPatienceStart + 8s));
  EXPECT_FALSE(patience.exhausted(1, true, kPatienceStart + 10s));
  EXPECT_TRUE(patience.exhausted(1, true, kPatienceStart + 11s));
  EXPECT_FALSE(patience.exhausted(2, true, kPatienceStart + 11s)) << "each thing by itself";
  EXPECT_FALSE(patience.exhausted(1, false, kPatienceStart + 12s));
  EXPECT_FALSE(patience.exhausted(1, true, kPatienceStart + 13s)) << "begins anew";
  EXPECT_TRUE(patience.exhausted(1, true, kPatienceStart + 24s));
  patience.reset();
  EXPECT_FALSE(patience.exhausted(1, true, kPatienceStart + 25s));
}

}  // namespace
}  // namespace onemap::mapping
