#include "local/exposure.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "local/surface_builder.hpp"
#include "support/analytic_scene.hpp"
#include "support/true_surface.hpp"

namespace onemap::mapping {
namespace {

using test::RenderedFrame;

std::vector<RenderedFrame> walk_with(const std::vector<double>& exposures) {
  const test::Scene scene;
  const hal::Intrinsics k = test::small_camera();
  const RayTable rays(k);
  std::vector<RenderedFrame> out;
  for (std::size_t i = 0; i < exposures.size(); ++i) {
    const double s = -0.6 + 1.2 * static_cast<double>(i) / static_cast<double>(exposures.size() - 1);
    out.push_back(test::render(scene, k, rays, test::look_at({-0.8, 0.3 * s, 0.4}, {0.6, 1.6 * s, 0.2})));
    for (std::uint8_t& c : out.back().rgb)
      c = static_cast<std::uint8_t>(std::min(255.0, std::lround(c * exposures[i]) + 0.0));
  }
  return out;
}

SurfaceBuilderConfig builder_config() {
  SurfaceBuilderConfig config;
  config.map.image_pixels = 640 * 480;
  return config;
}

// Half of the frames into the submap of one keyframe, half into that of another.
std::map<std::uint32_t, std::map<BlockKey, std::vector<Voxel>>> built(const std::vector<RenderedFrame>& frames,
                                                                      bool two_submaps) {
  SurfaceBuilder builder(builder_config());
  const RayTable rays(frames.front().intrinsics);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const SubmapAnchor anchor{two_submaps && 2 * i >= frames.size() ? 1u : 0u, Pose{}};
    EXPECT_TRUE(builder.integrate(frames[i].view(), rays, frames[i].T_world_camera.inverse(), anchor));
  }
  std::map<std::uint32_t, std::map<BlockKey, std::vector<Voxel>>> out;
  builder.for_each([&](const SubmapAnchor& anchor, const VoxelMap& map) {
    map.for_each([&](const BlockView& block) {
      out[anchor.keyframe][block.key] = {block.voxels.begin(), block.voxels.end()};
    });
  });
  return out;
}

// Of nine tenths of the voxels the map is at most so much (a share) darker or brighter than what a steady camera makes.
template <class Map>
double unevenness(const Map& map, const Map& steady) {
  std::vector<double> off;
  for (const auto& [anchor, blocks] : map)
    for (const auto& [key, voxels] : blocks)
      for (std::size_t i = 0; i < voxels.size(); ++i) {
        const Voxel& expected = steady.at(anchor).at(key)[i];
        if (voxels[i].color_weight == 0 || expected.color_weight == 0) continue;
        const Rgb a = voxels[i].color(), b = expected.color();
        off.push_back(std::abs((a[0] + a[1] + a[2]) / static_cast<double>(b[0] + b[1] + b[2]) - 1));
      }
  const auto at = off.begin() + static_cast<std::ptrdiff_t>(off.size() * 9 / 10);
  std::nth_element(off.begin(), at, off.end());
  return *at;
}

// The camera's exposure jumps on the way, by factors of nearly two, down and up.
TEST(Exposure, ItsJumpsLeaveNoSeam) {
  for (const auto& [first, then] : {std::pair(1.0, 0.55), std::pair(0.55, 1.0)})
    for (const bool two_submaps : {false, true}) {
      std::vector<double> jumping(8, first);
      jumping.resize(16, then);
      const auto steady = built(walk_with(std::vector<double>(16, first)), two_submaps);
      const auto map = built(walk_with(jumping), two_submaps);
      EXPECT_LT(unevenness(map, steady), 0.1 * std::abs(then / first - 1)) << first << " " << two_submaps;
    }
}

// A simulated camera with its vignetting and noise: to the bit what its images are.
TEST(Exposure, ASteadyCamerasColoursAreItsOwn) {
  const test::RoomFrames seen = test::room_frames("simulated:living-room?frames=160&width=320&height=240", 8);
  ASSERT_EQ(seen.frames.size(), 20u);
  const RayTable rays(seen.intrinsics);
  SurfaceBuilder builder(builder_config());
  VoxelMap plain(builder_config().map);
  for (const test::RoomFrame& f : seen.frames) {
    const hal::FrameView frame{{}, {}, 0, &seen.intrinsics, f.rgb, f.depth};
    if (builder.integrate(frame, rays, f.T_world_camera.inverse(), {0, Pose{}}))
      plain.integrate(frame, rays, f.T_world_camera.inverse().inverse());
  }
  builder.for_each([&](const SubmapAnchor&, const VoxelMap& map) { EXPECT_EQ(map.digest(), plain.digest()); });
}

// What was evened out is what the next frame is measured by, so the gain has an end.
TEST(Exposure, ItsGainIsBounded) {
  Exposure exposure(4);
  const std::vector<std::uint8_t> rgb{0, 100, 200};
  exposure.measured(20);
  EXPECT_EQ(exposure.gain(), 128);
  EXPECT_THAT(exposure.evened(rgb), testing::ElementsAre(0, 50, 100));
  exposure.measured(std::nullopt);
  EXPECT_EQ(exposure.gain(), 128) << "as the frame before";
  exposure.measured(1000);
  EXPECT_EQ(exposure.gain(), 512);
  EXPECT_THAT(exposure.evened(rgb), testing::ElementsAre(0, 200, 255));
  exposure.measured(256 + 32);
  EXPECT_EQ(exposure.evened(rgb).data(), rgb.data()) << "near one it is one";
}

// What is clipped is at least as bright as it says: darkened, a white wall would be grey.
TEST(Exposure, WhiteStaysWhiteAndTheOrderOfBrightnessIsKept) {
  std::vector<std::uint8_t> greys;  // each
  for (int i = 0; i < 256; ++i) greys.insert(greys.end(), 3, static_cast<std::uint8_t>(i));
  for (const int ratio : {128, 180, 220, 300, 512}) {
    Exposure exposure(256);
    exposure.measured(ratio);
    const auto evened = exposure.evened(greys);
    EXPECT_EQ(evened[3 * 255], 255) << ratio;
    EXPECT_EQ(evened[0], 0) << ratio;
    EXPECT_EQ(evened[3 * 100], (100 * ratio + 128) / 256) << ratio;
    for (std::size_t i = 3; i < greys.size(); ++i) {
      EXPECT_GE(evened[i], evened[i - 3]) << ratio << " at " << i / 3;
      EXPECT_LE(evened[i], evened[i - 3] + 5) << ratio << " at " << i / 3;
    }
  }
}

TEST(Exposure, ABrightPixelKeepsItsColour) {
  Exposure exposure(2);
  exposure.measured(128);
  const auto evened = exposure.evened(std::vector<std::uint8_t>{100, 150, 250, 100, 150, 200});
  const double of_bright = evened[2];
  EXPECT_GT(of_bright, 200);
  EXPECT_NEAR(evened[0] / of_bright, 0.4, 0.005);
  EXPECT_NEAR(evened[1] / of_bright, 0.6, 0.005);
  EXPECT_THAT(std::vector(evened.begin() + 3, evened.end()), testing::ElementsAre(50, 75, 100));
}

TEST(Exposure, SaysHowMuchBrighterTheMapIs) {
  const auto frames = walk_with({1.0, 0.5});
  const RayTable rays(frames[0].intrinsics);
  VoxelMap map(builder_config().map);
  EXPECT_FALSE(brightness_ratio(map, frames[0].view(), rays, frames[0].T_world_camera)) << "nothing is there";
  map.integrate(frames[0].view(), rays, frames[0].T_world_camera);
  RenderedFrame dark = frames[0];
  for (std::uint8_t& c : dark.rgb) c = c / 2;
  const auto ratio = brightness_ratio(map, dark.view(), rays, dark.T_world_camera);
  ASSERT_TRUE(ratio);
  EXPECT_NEAR(*ratio, 512, 12);
  hal::FrameView colourless = frames[0].view();
  colourless.rgb = {};
  EXPECT_FALSE(brightness_ratio(map, colourless, rays, frames[0].T_world_camera));
  std::ranges::fill(dark.rgb, std::uint8_t{255});
  EXPECT_FALSE(brightness_ratio(map, dark.view(), rays, dark.T_world_camera)) << "white says nothing";
}

}  // namespace
}  // namespace onemap::mapping
