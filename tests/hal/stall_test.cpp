#include "hal/stall.hpp"

#include <gtest/gtest.h>

namespace onemap::hal {
namespace {

using namespace std::chrono_literals;

TEST(Stall, IsFiveSecondsOfWaitsThatBroughtNothing) {
  Stall stall;
  for (int i = 0; i < 49; ++i) EXPECT_FALSE(stall.waited(100ms));
  EXPECT_TRUE(stall.waited(100ms));
  EXPECT_FALSE(stall.waited(4999ms)) << "it begins anew";
  stall.came();
  EXPECT_FALSE(stall.waited(4999ms));
  EXPECT_TRUE(stall.waited(1ms));
}

}  // namespace
}  // namespace onemap::hal
