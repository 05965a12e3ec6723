#include "hal/base/ids.hpp"

#include <gtest/gtest.h>

namespace onemap {
namespace {

TEST(RobotId, ValidNames) {
  for (const char* name : {"robot1", "A", "a.b-c_9", "0123456789abcdef"})
    EXPECT_TRUE(RobotId::valid_name(name)) << name;
  for (const char* name : {"", ".hidden", "0123456789abcdefg", "a b", "a/b", "a\n", "r\xC3\xB6", "a:1"})
    EXPECT_FALSE(RobotId::valid_name(name)) << name;
  EXPECT_FALSE(RobotId::valid_name(std::string_view("a\0b", 3)));
}

TEST(RobotId, NamesComeBack) {
  for (const char* name : {"robot1", "0123456789abcdef", "x"}) EXPECT_EQ(RobotId::from_name(name).name(), name);
  EXPECT_EQ(RobotId{}.name(), "");
}

TEST(RobotId, OrderIsThatOfUnsignedBytes) {
  EXPECT_LT(RobotId::from_name("a"), RobotId::from_name("ab"));
  EXPECT_LT(RobotId::from_name("ab"), RobotId::from_name("b"));
  EXPECT_EQ(RobotId::from_name("a"), RobotId::from_name("a"));
  RobotId low, high;
  low.bytes[0] = 0x7F;
  high.bytes[0] = 0x80;
  EXPECT_LT(low, high);
}

}  // namespace
}  // namespace onemap
