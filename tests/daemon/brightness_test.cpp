#include "daemon/brightness.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace onemap::daemon {
namespace {

TEST(Brightness, IsTheMeanOfAnImage) {
  std::vector<std::uint8_t> rgb(3 * 640 * 480);
  EXPECT_EQ(brightness_of(rgb), 0.0);
  for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = (i / 3) % 640 < 320 ? 50 : 150;
  EXPECT_NEAR(brightness_of(rgb), 100, 2) << "left and right count alike";
  EXPECT_EQ(brightness_of({}), 0.0);
}

}  // namespace
}  // namespace onemap::daemon
