#include "daemon/control/output_actions.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace onemap::daemon {
namespace {

using testing::HasSubstr;

TEST(PathBelow, IsANameBelowOutAndNothingElseOfTheMachine) {
  const auto path = [](const std::string& name) { return path_below("/o", Json{{"path", name}}, "x"); };
  EXPECT_EQ(path("a.omap").value(), "/o/a.omap");
  EXPECT_EQ(path("a/b..c").value(), "/o/a/b..c");
  EXPECT_EQ(path_below("/o", Json::object(), "x").value(), "/o/x");
  for (const char* wrong : {"", "/etc/passwd", "..", "../x", "a/../../x", "a/..", "a\nb"}) {
    ASSERT_FALSE(path(wrong).ok()) << wrong;
    EXPECT_THAT(path(wrong).error().text(), HasSubstr("below OUT (/o)"));
  }
  EXPECT_FALSE(path_below("/o", Json{{"path", 3}}, "x").ok());
  EXPECT_FALSE(path_below("/o", Json::object(), "").ok()) << "nothing was said";
}

}  // namespace
}  // namespace onemap::daemon
