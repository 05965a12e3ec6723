// Other sizes than 640x480 through the V4L2 calls, on cameras that umockdev plays.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "hal/backends/v4l2.hpp"
#include "hal/camera_contract.hpp"
#include "hal/imaging/image_size.hpp"
#include "hal/v4l2/mock_machine.hpp"

namespace onemap::hal {
namespace {

using namespace std::chrono_literals;
using imaging::ImageSize;
using test::MockMode;
using test::MockNodeConfig;
using testing::HasSubstr;

std::pair<std::uint32_t, std::uint32_t> mode_of(ImageSize size) {
  return {static_cast<std::uint32_t>(size.width), static_cast<std::uint32_t>(size.height)};
}

std::string calibration_of(ImageSize size) {
  return fmt::format("width {0}\nheight {1}\nfx {0}\nfy {0}\ncx {2}\ncy {3}\ndepth_scale 1000\n", size.width,
                     size.height, (size.width - 1) / 2.0, (size.height - 1) / 2.0);
}

class V4l2Sizes : public testing::TestWithParam<ImageSize> {};

// The camera's first mode is another: the size is what is asked for.
TEST_P(V4l2Sizes, StreamWithoutACopyOfTheDepthImage) {
  test::Machine machine;
  if (!machine.missing().empty()) GTEST_SKIP() << machine.missing();
  MockNodeConfig depth = test::depth_node(), colour = test::colour_node();
  depth.sizes = colour.sizes = {{640, 480}, mode_of(GetParam())};
  machine.add(1, 0, depth, colour);
  machine.write("calibration.txt", calibration_of(GetParam()));
  const auto opened = open_text(open_v4l2, "v4l2:?calibration=" + machine.file("calibration.txt"));
  ASSERT_TRUE(opened.ok()) << opened.error().text();
  DepthCamera& camera = **opened;
  const auto [width, height] = GetParam();
  EXPECT_EQ(camera.intrinsics().width, width);
  EXPECT_EQ(camera.intrinsics().height, height);
  EXPECT_THAT(camera.description(),
              HasSubstr(fmt::format("Z16 {0}x{1}, colour /dev/video1 YUYV {0}x{1}", width, height)));
  FramePool pool(camera.intrinsics(), 1);
  Frame frame = pool.acquire();
  for (int i = 0; i < 5; ++i) {
    ASSERT_EQ(camera.grab(frame, 10s), Grab::frame) << camera.last_error().text();
    const FrameView view = frame.view();
    ASSERT_EQ(view.depth.size(), GetParam().pixels());
    EXPECT_NE(view.depth.data(), frame.depth().data()) << "no copy";
    EXPECT_EQ(view.depth.back(), view.depth.front() + width - 1 + 2 * (height - 1));
    EXPECT_EQ(view.rgb[3 * GetParam().pixels() - 3], view.rgb[3 * static_cast<std::size_t>(width - 1)]);
    EXPECT_EQ(view.rgb.size(), 3 * GetParam().pixels());
  }
  EXPECT_EQ(camera.counters().missed, 0u);
}

INSTANTIATE_TEST_SUITE_P(Sizes, V4l2Sizes,
                         testing::Values(ImageSize{320, 240}, ImageSize{848, 480}, ImageSize{1280, 720}),
                         [](const auto& at) { return fmt::format("{}x{}", at.param.width, at.param.height); });

// A RealSense of these sizes, by the calibration that is shipped for it.
TEST(V4l2SizesShipped, ARealSenseOpensAtItsSizesWithoutAFile) {
  for (const ImageSize size : {ImageSize{848, 480}, {1280, 720}}) {
    test::Machine machine;
    if (!machine.missing().empty()) GTEST_SKIP() << machine.missing();
    MockNodeConfig depth = test::depth_node(), colour = test::colour_node();
    depth.sizes = colour.sizes = {{640, 480}, mode_of(size)};
    machine.add(1, 0, depth, colour);
    const auto opened = open_text(open_v4l2, fmt::format("v4l2:?size={}x{}", size.width, size.height));
    ASSERT_TRUE(opened.ok()) << opened.error().text();
    EXPECT_THAT((*opened)->description(),
                HasSubstr(fmt::format("nominal for realsense-d435-{0}x{1}", size.width, size.height)));
    EXPECT_EQ(imaging::size_of((*opened)->intrinsics()), size);
    FramePool pool((*opened)->intrinsics(), 1);
    Frame frame = pool.acquire();
    ASSERT_EQ((*opened)->grab(frame, 10s), Grab::frame) << (*opened)->last_error().text();
    const auto filled = std::ranges::count_if(frame.view().depth, [](std::uint16_t z) { return z != 0; });
    EXPECT_GT(static_cast<double>(filled), 0.8 * static_cast<double>(size.pixels()));
  }
}

// onemapctl calibrate looks at images of one size, which these have not.
TEST(V4l2SizesShipped, CamerasWhoseDepthHasAnotherShapeSayWhyTheyCannotBeCalibrated) {
  for (const char* id : {"2bc5:0669", "2bc5:0670"}) {
    test::Machine machine;
    if (!machine.missing().empty()) GTEST_SKIP() << machine.missing();
    machine.add(1, 0, test::depth_node(), test::colour_node(), id);
    const auto opened = open_text(open_v4l2, "v4l2:?registration=none");
    ASSERT_FALSE(opened.ok()) << id;
    EXPECT_THAT(opened.error().text(), testing::AllOf(HasSubstr("onemapctl calibrate"),
                                                      HasSubstr("has another shape than its colour, 640x360"),
                                                      HasSubstr("cannot be calibrated")));
  }
}

constexpr double kApart_m = 0.015, kDepthFocal_px = 420, kColourFocal_px = 900, kBox_m = 0.8, kWall_m = 1.5;

// What a depth camera of 848x480 sees: a wall with a box before its middle.
MockNodeConfig box_before_a_wall() {
  MockNodeConfig config;
  config.formats = {test::kZ16};
  config.sizes = {{848, 480}};
  config.content = [](const MockMode& mode, std::uint32_t, std::uint8_t* out, std::uint32_t stride) {
    for (std::uint32_t y = 0; y < mode.height; ++y)
      for (std::uint32_t x = 0; x < mode.width; ++x) {
        const bool box = x >= 384 && x < 464 && y >= 200 && y < 280;
        const auto value = static_cast<std::uint32_t>(1000 * (box ? kBox_m : kWall_m));
        out[y * stride + 2 * x] = static_cast<std::uint8_t>(value);
        out[y * stride + 2 * x + 1] = static_cast<std::uint8_t>(value >> 8);
      }
  };
  return config;
}

// Where the colour camera sees what the depth camera has in a column.
double column(double depth_column, double z_m) {
  return kColourFocal_px * ((depth_column - 423.5) / kDepthFocal_px + kApart_m / z_m) + 639.5;
}

TEST(V4l2SizesApart, DepthOf848x480IsRegisteredToColourOf1280x720) {
  test::Machine machine;
  if (!machine.missing().empty()) GTEST_SKIP() << machine.missing();
  MockNodeConfig colour = test::colour_node();
  colour.sizes = {{1280, 720}};
  machine.add(1, 0, box_before_a_wall(), colour);
  machine.write("two-sizes.txt",
                fmt::format("width 1280\nheight 720\nfx {0}\nfy {0}\ncx 639.5\ncy 359.5\ndepth_scale 1000\n"
                            "depth_width 848\ndepth_height 480\ndepth_fx {1}\ndepth_fy {1}\ndepth_cx 423.5\n"
                            "depth_cy 239.5\ncolour_from_depth_x {2}\n",
                            kColourFocal_px, kDepthFocal_px, kApart_m));
  const auto opened = open_text(open_v4l2, "v4l2:?calibration=" + machine.file("two-sizes.txt"));
  ASSERT_TRUE(opened.ok()) << opened.error().text();
  DepthCamera& camera = **opened;
  EXPECT_THAT(camera.description(), HasSubstr("Z16 848x480, colour /dev/video1 YUYV 1280x720"));
  FramePool pool(camera.intrinsics(), 1);
  Frame frame = pool.acquire();
  ASSERT_EQ(camera.grab(frame, 10s), Grab::frame) << camera.last_error().text();
  const auto depth = frame.view().depth;
  ASSERT_EQ(depth.size(), 1280u * 720u);
  const auto row = [&](std::size_t y) { return depth.subspan(y * 1280, 1280); };
  // Above the box there is the wall from side to side: finer pixels, and no hole.
  EXPECT_EQ(std::ranges::count(row(100), 1500), 1280);
  const auto box = std::ranges::count(row(360), 800), wall = std::ranges::count(row(360), 1500),
             hidden = std::ranges::count(row(360), 0);
  EXPECT_EQ(box + wall + hidden, 1280);
  EXPECT_NEAR(static_cast<double>(box), 80 * kColourFocal_px / kDepthFocal_px, 2);
  EXPECT_NEAR(static_cast<double>(hidden), column(384, kBox_m) - column(384, kWall_m), 2) << "behind the box";
  const auto begin = static_cast<std::size_t>(column(383.5, kBox_m)),
             end = static_cast<std::size_t>(column(463.5, kBox_m));
  EXPECT_EQ(row(360)[begin + 2], 800);
  EXPECT_EQ(row(360)[end - 2], 800);
  EXPECT_EQ(row(360)[end + 2], 1500);
  EXPECT_EQ(row(360)[begin - 3], 0);
}

}  // namespace
}  // namespace onemap::hal
