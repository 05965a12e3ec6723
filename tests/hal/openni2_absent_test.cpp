#include <gtest/gtest.h>

#include "hal/backends/openni2.hpp"

// What the other OpenNI2 tests become where the library is not there.
#ifndef ONEMAP_OPENNI2_DIR
namespace onemap::hal {
namespace {

TEST(OpenNi2Absent, SaysSo) {
  const auto camera = open_openni2(*parse_camera_address("openni2:"));
  ASSERT_FALSE(camera.ok());
  EXPECT_NE(camera.error().text().find("libopenni2-dev"), std::string::npos);
  GTEST_SKIP() << "libopenni2-dev is not installed: the OpenNI2 backend and its tests were not built";
}

}  // namespace
}  // namespace onemap::hal
#endif
