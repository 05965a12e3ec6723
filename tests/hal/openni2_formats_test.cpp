#ifdef ONEMAP_OPENNI2_DIR  // else openni2_absent_test.cpp
// Image sizes and forms of colour through the real OpenNI2 library, from a device that has no other.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "hal/backends/openni2.hpp"
#include "hal/backends/simulated.hpp"
#include "support/openni2_devices.hpp"

namespace onemap::hal {
namespace {

using namespace std::chrono_literals;

struct OneFrame {
  Intrinsics k;
  std::string description;
  std::vector<std::uint8_t> rgb;
  std::vector<std::uint16_t> depth;
};

OneFrame first_frame_of(std::unique_ptr<DepthCamera> camera) {
  OneFrame out{camera->intrinsics(), camera->description(), {}, {}};
  FramePool pool(out.k, 1);
  Frame frame = pool.acquire();
  Grab grab = Grab::timeout;
  for (int tries = 0; tries < 400 && grab != Grab::frame; ++tries) grab = camera->grab(frame, 50ms);
  EXPECT_EQ(grab, Grab::frame) << camera->last_error().text();
  out.rgb.assign(frame.rgb().begin(), frame.rgb().end());
  out.depth.assign(frame.depth().begin(), frame.depth().end());
  return out;
}

OneFrame by_openni2(const std::string& room, const std::string& more) {
  test::OpenNi2Devices devices;
  devices.plug("a", "room " + room + "\non_demand 1\nhundred_um 1\n" + more);
  auto camera = open_openni2(*parse_camera_address("openni2:"));
  EXPECT_TRUE(camera.ok()) << (camera.ok() ? "" : camera.error().text());
  return camera.ok() ? first_frame_of(std::move(*camera)) : OneFrame();
}

OneFrame by_simulation(const std::string& room) {
  return first_frame_of(std::move(open_simulated(*parse_camera_address(room))).value());
}

TEST(OpenNi2Formats, ImagesOfEverySizeComePixelForPixel) {
  for (const auto& [width, height] : {std::pair(320, 240), {848, 480}, {1280, 720}}) {
    const std::string room =
        "simulated:office?seed=3&width=" + std::to_string(width) + "&height=" + std::to_string(height);
    const OneFrame got = by_openni2(room, ""), truth = by_simulation(room);
    EXPECT_EQ(got.k.width, width);
    EXPECT_EQ(got.k.height, height);
    EXPECT_EQ(got.rgb, truth.rgb) << width;
    ASSERT_EQ(got.depth.size(), truth.depth.size());
    for (std::size_t i = 0; i < truth.depth.size(); ++i) ASSERT_EQ(got.depth[i], 2 * truth.depth[i]) << i;
  }
}

TEST(OpenNi2Formats, ColourThatIsNoRgbIsDecoded) {
  const std::string room = "simulated:office?seed=3&width=320&height=240";
  const OneFrame truth = by_simulation(room);
  for (const auto& [colour, said] : {std::pair("yuv422", "YUV422"), {"yuyv", "YUYV"}}) {
    const OneFrame got = by_openni2(room, std::string("colour ") + colour + "\n");
    EXPECT_THAT(got.description, testing::HasSubstr(said));
    ASSERT_EQ(got.rgb.size(), truth.rgb.size());
    double apart = 0;  // two pixels share their colour; green is nearly brightness
    for (std::size_t i = 1; i < got.rgb.size(); i += 3) apart += std::abs(got.rgb[i] - truth.rgb[i]);
    EXPECT_LT(3 * apart / static_cast<double>(got.rgb.size()), 4) << colour;
  }
  const OneFrame grey = by_openni2(room, "colour grey\n");
  ASSERT_EQ(grey.rgb.size(), truth.rgb.size());
  for (std::size_t i = 0; i < grey.rgb.size(); ++i) ASSERT_EQ(grey.rgb[i], truth.rgb[i - i % 3 + 1]) << i;
}

TEST(OpenNi2Formats, ColourThatCannotBeDecodedIsRefusedWithWhatThereIs) {
  test::OpenNi2Devices devices;
  devices.plug("a", "room simulated:office?width=320&height=240\non_demand 1\ncolour jpeg\n");
  const auto camera = open_openni2(*parse_camera_address("openni2:"));
  ASSERT_FALSE(camera.ok());
  EXPECT_THAT(camera.error().text(), testing::HasSubstr("colour has 320x240@30 in a format that is not decoded"));
}

}  // namespace
}  // namespace onemap::hal
#endif
