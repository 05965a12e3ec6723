#include "daemon/cameras.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/options.hpp"

namespace onemap::daemon {
namespace {

TEST(Cameras, TheListSaysWhatIsThereAndWhatAutoOpens) {
  const hal::CameraInfo cameras[] = {{"v4l2:/dev/video0", "An old one", "", "no colour node"},
                                     {"v4l2:/dev/video2", "A good one 123", "depth Z16 640x480", ""}};
  EXPECT_EQ(cameras_text(cameras),
            "v4l2:/dev/video0\n  An old one\n  cannot be used: no colour node\n"
            "v4l2:/dev/video2\n  A good one 123\n  depth Z16 640x480\nauto is v4l2:/dev/video2\n");
  EXPECT_THAT(cameras_text(std::span(cameras).first(1)), testing::EndsWith("none of them can be used\n"));
  EXPECT_THAT(cameras_text({}), testing::HasSubstr("no camera found"));
}

TEST(Cameras, TheOptionEndsWithTheList) {
  const auto parsed = parse_daemon_options({"--cameras"});
  EXPECT_FALSE(parsed.value.has_value());
  EXPECT_EQ(parsed.exit, Exit::done);
  EXPECT_FALSE(parsed.text.empty());
}

TEST(Cameras, EveryBackendSaysHowItIsAddressed) {
  for (const hal::Backend& backend : camera_backends()) {
    EXPECT_THAT(std::string(backend.description), testing::HasSubstr(std::string(backend.name) + ":"));
    EXPECT_NE(backend.open, nullptr);
  }
}

}  // namespace
}  // namespace onemap::daemon
