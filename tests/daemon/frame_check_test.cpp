#include "daemon/frame_check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "hal/backends/simulated.hpp"

namespace onemap::daemon {
namespace {

using testing::HasSubstr;

std::unique_ptr<hal::DepthCamera> walk(const std::string& options) {
  const auto address = hal::parse_camera_address("simulated:living-room?width=160&height=120&frames=60&" + options);
  auto camera = hal::open_simulated(*address);
  if (!camera) throw std::runtime_error(camera.error().text());
  return std::move(*camera);
}

struct Looked {
  std::string began, ended;
  std::vector<int> frozen;  // frames
  FrameCheck check;
};
Looked look(const std::string& options) {
  auto camera = walk(options);
  hal::FramePool pool(camera->intrinsics(), 1);
  hal::Frame frame = pool.acquire();
  Looked looked;
  for (int i = 0; camera->grab(frame, {}) == hal::Grab::frame; ++i) {
    const auto seen = looked.check.look(frame.view());
    looked.began += seen.began;
    looked.ended += seen.ended;
    if (seen.frozen) looked.frozen.push_back(i);
  }
  return looked;
}

std::vector<std::uint64_t> counts(const FrameCheck& check) {
  return {check.frames(FrameFault::frozen), check.frames(FrameFault::black), check.frames(FrameFault::saturated),
          check.frames(FrameFault::no_depth)};
}

TEST(FrameCheck, AGoodWalkHasNoFaults) {
  for (const char* noise : {"noise=kinect", "noise=none"}) {
    const Looked looked = look(noise);
    EXPECT_EQ(looked.began + looked.ended, "");
    EXPECT_THAT(counts(looked.check), testing::ElementsAre(0, 0, 0, 0));
  }
}

TEST(FrameCheck, EachFaultIsSaidOnceAndSoIsItsEnd) {
  Looked looked = look("freeze_at=20&fault_for=25");
  EXPECT_THAT(looked.began, HasSubstr("same picture again and again"));
  EXPECT_THAT(looked.ended, HasSubstr("its pictures change again, after 25 frames"));
  EXPECT_THAT(counts(looked.check), testing::ElementsAre(25, 0, 0, 0));
  EXPECT_EQ(looked.frozen.size(), 16u) << "from the tenth on";
  EXPECT_EQ(looked.frozen.front(), 29);
  looked = look("black_at=20&fault_for=25");
  EXPECT_THAT(looked.began, HasSubstr("are black"));
  EXPECT_THAT(looked.ended, HasSubstr("no more black, after 25 frames"));
  EXPECT_THAT(counts(looked.check), testing::ElementsAre(0, 25, 0, 0));
  looked = look("saturate_at=20&fault_for=25");
  EXPECT_THAT(looked.began, HasSubstr("are white"));
  EXPECT_THAT(counts(looked.check), testing::ElementsAre(0, 0, 25, 0));
  looked = look("no_depth_at=20");
  EXPECT_THAT(looked.began, HasSubstr("has no depth"));
  EXPECT_EQ(looked.ended, "") << "to the end";
  EXPECT_THAT(counts(looked.check), testing::ElementsAre(0, 0, 0, 40));
  EXPECT_TRUE(looked.frozen.empty());
}

TEST(FrameCheck, AShortFaultIsCountedAndNotSaid) {
  const Looked looked = look("black_at=20&fault_for=9");
  EXPECT_EQ(looked.began + looked.ended, "");
  EXPECT_EQ(looked.check.frames(FrameFault::black), 9u);
}

}  // namespace
}  // namespace onemap::daemon
