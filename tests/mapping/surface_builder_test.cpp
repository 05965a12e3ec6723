#include "local/surface_builder.hpp"

#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "support/poses.hpp"

namespace onemap::mapping {
namespace {

hal::Intrinsics small_camera() {
  hal::Intrinsics k;
  k.width = 160;
  k.height = 120;
  k.fx = k.fy = 131;
  k.cx = 79.5;
  k.cy = 59.5;
  return k;
}

// A camera that looks at a wall 2 m away, from different places.
struct Wall {
  Wall() : rays(k), depth(160 * 120, static_cast<std::uint16_t>(2 * k.depth_scale)), builder(config()) {}
  static SurfaceBuilderConfig config() {
    SurfaceBuilderConfig out;
    out.map.budget_bytes = 32u << 20;
    out.map.image_pixels = 160 * 120;
    return out;
  }
  bool integrate(double x_m, double angle_deg = 0) {
    const Pose T_robot_camera{test::rotation({0, 0, 1}, angle_deg * M_PI / 180), {x_m, 0, 0}};
    hal::FrameView frame;
    frame.intrinsics = &k;
    frame.depth = depth;
    return builder.integrate(frame, rays, T_robot_camera.inverse());
  }
  hal::Intrinsics k = small_camera();
  RayTable rays;
  std::vector<std::uint16_t> depth;
  SurfaceBuilder builder;
};

TEST(SurfaceBuilder, LeavesOutFramesThatHardlyMoved) {
  Wall wall;
  EXPECT_TRUE(wall.integrate(0)) << "the first";
  EXPECT_FALSE(wall.integrate(0));
  EXPECT_FALSE(wall.integrate(0.02, 1.5));
  EXPECT_TRUE(wall.integrate(0.04)) << "since the last that was fused, not since the last";
  EXPECT_FALSE(wall.integrate(0.02));
  EXPECT_TRUE(wall.integrate(0.04, 2.1));
  EXPECT_EQ(wall.builder.voxels().counters().integrated_frames, 3u);
}

// Along a long wall: what the camera has left behind settles, and goes out once.
TEST(SurfaceBuilder, HandsOutWhatHasSettledAndAtTheEndAllTheRest) {
  Wall wall;
  SubmapRecord record;
  std::set<BlockKey> out;
  const auto take = [&] {
    while (wall.builder.take_submap(record)) {
      EXPECT_LE(record.blocks.size(), 256u);
      for (const SubmapBlock& block : record.blocks) EXPECT_TRUE(out.insert(block.key).second) << "twice";
    }
  };
  for (int i = 0; i < 14; ++i) {
    wall.integrate(0.5 * i);
    take();
  }
  EXPECT_TRUE(out.empty()) << "it is not looked for yet";
  wall.integrate(0.5 * 14);
  take();
  EXPECT_GT(out.size(), 20u);
  for (const BlockKey& key : out) EXPECT_LT(key.x * 0.16, 1.5) << "one of the last ten frames sees it";
  const std::size_t settled = out.size();
  take();
  EXPECT_EQ(out.size(), settled);
  wall.builder.finish();
  take();
  EXPECT_EQ(out.size(), wall.builder.voxels().used());
}

TEST(SurfaceBuilder, ABlockThatChangesAgainGoesOutAgain) {
  Wall wall;
  SubmapRecord first, second;
  wall.integrate(0);
  wall.builder.finish();
  ASSERT_TRUE(wall.builder.take_submap(first));
  while (wall.builder.take_submap(second)) {
  }
  wall.integrate(0.04);
  ASSERT_TRUE(wall.builder.take_submap(second));
  std::set<BlockKey> before, both;
  for (const SubmapBlock& block : first.blocks) before.insert(block.key);
  for (const SubmapBlock& block : second.blocks)
    if (before.contains(block.key)) both.insert(block.key);
  EXPECT_GT(both.size(), 50u);
}

}  // namespace
}  // namespace onemap::mapping
