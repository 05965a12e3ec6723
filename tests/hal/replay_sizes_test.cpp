// Recordings of other sizes than 640x480, written by our own encoders from a simulated camera.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "hal/backends/replay.hpp"
#include "hal/backends/simulated.hpp"
#include "hal/imaging/encode_image.hpp"
#include "hal/imaging/image_size.hpp"
#include "support/temp_folder.hpp"

namespace onemap::hal {
namespace {

using namespace std::chrono_literals;
using imaging::ImageSize;
using testing::HasSubstr;

constexpr int kFrames = 3;

class ReplaySizes : public testing::TestWithParam<ImageSize> {
 protected:
  std::unique_ptr<DepthCamera> room() const {
    const auto [width, height] = GetParam();
    return open_simulated(*parse_camera_address(fmt::format("simulated:office?seed=7&frames={}&width={}&height={}",
                                                            kFrames, width, height)))
        .value();
  }
  void record(const test::TempFolder& folder) const {
    const auto camera = room();
    const Intrinsics& k = camera->intrinsics();
    FramePool pool(k, 1);
    Frame frame = pool.acquire();
    std::string rgb, depth;
    std::vector<std::uint8_t> file;
    while (camera->grab(frame, 0ms) == Grab::frame) {
      ASSERT_TRUE(imaging::encode_colour(GetParam(), frame.rgb(), file));
      folder.write(fmt::format("rgb/{}.png", frame.index), file);
      ASSERT_TRUE(imaging::encode_depth(GetParam(), frame.depth(), file));
      folder.write(fmt::format("depth/{}.png", frame.index), file);
      const double time_s = to_seconds(frame.colour_time);
      rgb += fmt::format("{:.6f} rgb/{}.png\n", time_s, frame.index);
      depth += fmt::format("{:.6f} depth/{}.png\n", time_s, frame.index);
    }
    folder.write("rgb.txt", rgb);
    folder.write("depth.txt", depth);
    folder.write("calibration.txt",
                 fmt::format("fx {}\nfy {}\ncx {}\ncy {}\ndepth_scale {}\n", k.fx, k.fy, k.cx, k.cy, k.depth_scale));
  }
};

TEST_P(ReplaySizes, PlayPixelForPixel) {
  const test::TempFolder folder;
  record(folder);
  const auto address = parse_camera_address("replay:" + folder.path().string());
  const auto camera = open_replay(*address);
  ASSERT_TRUE(camera.ok()) << camera.error().text();
  const auto expected_camera = room();
  EXPECT_EQ((*camera)->intrinsics(), expected_camera->intrinsics());
  EXPECT_THAT((*camera)->description(), HasSubstr(fmt::format("{}x{}", GetParam().width, GetParam().height)));
  FramePool pool((*camera)->intrinsics(), 2);
  EXPECT_GE(pool.bytes(), 2 * 5 * GetParam().pixels()) << "the pool is of this size";
  Frame frame = pool.acquire(), expected = pool.acquire();
  for (int i = 0; i < kFrames; ++i) {
    ASSERT_EQ((*camera)->grab(frame, 0ms), Grab::frame) << (*camera)->last_error().text();
    ASSERT_EQ(expected_camera->grab(expected, 0ms), Grab::frame);
    EXPECT_EQ(frame.rgb().size(), 3 * GetParam().pixels());
    EXPECT_TRUE(std::ranges::equal(frame.rgb(), expected.rgb())) << i;
    EXPECT_TRUE(std::ranges::equal(frame.depth(), expected.depth())) << i;
    EXPECT_GT(std::ranges::count_if(frame.depth(), [](auto d) { return d != 0; }),
              static_cast<std::ptrdiff_t>(GetParam().pixels() / 4));
  }
  EXPECT_EQ((*camera)->grab(frame, 0ms), Grab::end);
}

INSTANTIATE_TEST_SUITE_P(Sizes, ReplaySizes,
                         testing::Values(ImageSize{320, 240}, ImageSize{848, 480}, ImageSize{1280, 720}),
                         [](const auto& at) { return fmt::format("{}x{}", at.param.width, at.param.height); });

}  // namespace
}  // namespace onemap::hal
