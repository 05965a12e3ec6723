#include "hal/backends/simulated.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "hal/frame_pool.hpp"

// The simulated camera against what must be true of any camera in a room: the same bytes every time, depth and colour
// that agree between frames under the true poses, noise of the stated size. Nothing here looks inside the backend.
namespace onemap::hal {
namespace {

struct Picture {
  FrameTime time{};
  std::uint64_t index = 0;
  std::vector<std::uint8_t> rgb;
  std::vector<std::uint16_t> depth;
};

CameraAddress address_of(const std::string& text) {
  auto address = parse_camera_address(text);
  EXPECT_TRUE(address.ok());
  return *address;
}

std::unique_ptr<DepthCamera> open(const std::string& text) {
  auto camera = open_simulated(address_of(text));
  EXPECT_TRUE(camera.ok()) << (camera.ok() ? "" : camera.error().text());
  return std::move(camera).value();
}

// The frames with the given numbers, in rising order.
std::vector<Picture> take(DepthCamera& camera, const std::set<std::uint64_t>& wanted) {
  FramePool pool(camera.intrinsics(), 1);
  std::vector<Picture> out;
  Frame frame = pool.acquire();
  for (std::uint64_t i = 0; i <= *wanted.rbegin(); ++i) {
    EXPECT_EQ(camera.grab(frame, std::chrono::milliseconds(0)), Grab::frame);
    if (!wanted.contains(i)) continue;
    out.push_back({frame.time, frame.index, {}, {}});
    out.back().rgb.assign(frame.rgb().begin(), frame.rgb().end());
    out.back().depth.assign(frame.depth().begin(), frame.depth().end());
  }
  return out;
}

std::vector<Picture> take(const std::string& text, const std::set<std::uint64_t>& wanted) {
  return take(*open(text), wanted);
}

TEST(Simulated, SameAddressGivesSameBytes) {
  for (const std::string scene : {"living-room", "office", "storage", "empty-hall", "corridor"}) {
    const std::string text = "simulated:" + scene + "?robot=2&width=160&height=120&seed=4";
    const auto a = take(text, {0, 3}), b = take(text, {0, 3});
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(a[i].rgb, b[i].rgb) << scene;
      EXPECT_EQ(a[i].depth, b[i].depth) << scene;
    }
    EXPECT_NE(a[0].rgb, a[1].rgb) << scene;
  }
}

TEST(Simulated, EndsAfterTheGivenFramesWithRisingTimes) {
  auto camera = open("simulated:empty-hall?frames=5&width=64&height=48&fps=25");
  EXPECT_EQ(camera->frames_expected(), 5u);
  const auto frames = take(*camera, {0, 1, 2, 3, 4});
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].index, i);
    EXPECT_EQ(frames[i].time - frames[0].time, std::chrono::milliseconds(40 * i));
  }
  FramePool pool(camera->intrinsics(), 1);
  Frame frame = pool.acquire();
  EXPECT_EQ(camera->grab(frame, std::chrono::milliseconds(0)), Grab::end);
  EXPECT_EQ(camera->counters().frames, 5u);
  EXPECT_EQ(camera->frames_expected(), 0u);
}

TEST(Simulated, BadAddressesSayWhatIsValid) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"simulated:cellar", "living-room, office, storage, empty-hall, corridor"},
      {"simulated:", "living-room"},
      {"simulated:office?robto=1", "known: robot=1..robots"},
      {"simulated:office?robot=0", "whole number from 1 to 3"},
      {"simulated:office?robot=4", "whole number from 1 to 3"},
      {"simulated:office?robot=two", "robot=two"},
      {"simulated:office?frames=10x", "frames=10x"},
      {"simulated:office?seed=-1", "seed=-1"},
      {"simulated:office?noise=some", "expected kinect or none"},
      {"simulated:office?near=2&far=1.5", "not beyond"},
      {"simulated:office?width=", "whole number from 64 to 1920"},
      {"simulated:office?fps=0", "from 1 to 120"},
  };
  for (const auto& [text, reason] : cases) {
    const auto camera = open_simulated(address_of(text));
    ASSERT_FALSE(camera.ok()) << text;
    EXPECT_NE(camera.error().text().find(reason), std::string::npos) << camera.error().text();
    EXPECT_NE(camera.error().text().find(text), std::string::npos) << camera.error().text();
    EXPECT_FALSE(simulated_truth(address_of(text)).ok()) << text;
  }
}

}  // namespace
}  // namespace onemap::hal
