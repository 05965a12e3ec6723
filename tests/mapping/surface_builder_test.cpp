#include "local/surface_builder.hpp"

#include <gtest/gtest.h>

#include <map>
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
  // Into the submap of an anchor that lies at anchor_x_m.
  bool integrate(double x_m, double angle_deg = 0, std::uint32_t anchor = 0, double anchor_x_m = 0) {
    hal::FrameView frame;
    frame.intrinsics = &k;
    frame.depth = depth;
    return builder.integrate(frame, rays, camera_at(x_m, angle_deg).inverse(), anchor_at(anchor, anchor_x_m));
  }
  static Pose camera_at(double x_m, double angle_deg = 0) {
    return {test::rotation({0, 0, 1}, angle_deg * M_PI / 180), {x_m, 0, 0}};
  }
  static SubmapAnchor anchor_at(std::uint32_t keyframe, double x_m) { return {keyframe, camera_at(x_m).inverse()}; }
  std::vector<SubmapRecord> take() {
    std::vector<SubmapRecord> out;
    for (SubmapRecord record; builder.take_submap(record);) out.push_back(record);
    return out;
  }
  std::map<std::uint32_t, std::size_t> blocks_by_anchor() const {
    std::map<std::uint32_t, std::size_t> out;
    builder.for_each([&](const SubmapAnchor& a, const VoxelMap& voxels) { out[a.keyframe] = voxels.used(); });
    return out;
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
  EXPECT_EQ(wall.builder.counters().integrated_frames, 3u);
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
  EXPECT_EQ(out.size(), wall.builder.blocks());
}

// Once it says clearly more than before.
TEST(SurfaceBuilder, ABlockThatChangesAgainGoesOutAgain) {
  Wall wall;
  SubmapRecord first, second;
  wall.integrate(0);
  wall.builder.finish();
  ASSERT_TRUE(wall.builder.take_submap(first));
  while (wall.builder.take_submap(second)) {
  }
  for (const double x_m : {0.04, 0.0, 0.04}) wall.integrate(x_m);
  ASSERT_TRUE(wall.builder.take_submap(second));
  std::set<BlockKey> before, both;
  for (const SubmapBlock& block : first.blocks) before.insert(block.key);
  for (const SubmapBlock& block : second.blocks)
    if (before.contains(block.key)) both.insert(block.key);
  EXPECT_GT(both.size(), 50u);
}

TEST(SurfaceBuilder, AKeyframeHangsOnTheNearestAnchorInReach) {
  Wall wall;
  const std::vector<SubmapAnchor> anchors{Wall::anchor_at(0, 0), Wall::anchor_at(4, 1.5), Wall::anchor_at(9, 1.7)};
  EXPECT_FALSE(wall.builder.choose(Wall::camera_at(0).inverse(), anchors)) << "none of them has a submap";
  wall.integrate(0, 0, 0, 0);
  wall.integrate(1.5, 0, 4, 1.5);
  const auto chosen = [&](double x_m, double angle_deg = 0) {
    const auto anchor = wall.builder.choose(Wall::camera_at(x_m, angle_deg).inverse(), anchors);
    return anchor ? static_cast<int>(anchor->keyframe) : -1;
  };
  EXPECT_EQ(chosen(0.3), 0);
  EXPECT_EQ(chosen(1.3), 4);
  EXPECT_EQ(chosen(0.6), 4) << "what is fused into stays as long as it is in reach";
  EXPECT_EQ(chosen(2.6), -1);
  EXPECT_EQ(chosen(0, 50), -1) << "turned away from all";
}

// A walk along a wall that is longer than the pool could hold: what is left goes to the shelf, and nothing is refused.
TEST(SurfaceBuilder, AWalkOfAnyLengthFitsThePool) {
  Wall wall;
  std::size_t blocks = 0;
  for (int metre = 0; metre < 12; ++metre)
    for (const double step : {0.0, 0.5}) {
      wall.integrate(metre + step, 0, static_cast<std::uint32_t>(metre), metre);
      for (const SubmapRecord& record : wall.take()) blocks += record.blocks.size();
    }
  wall.builder.finish();
  for (const SubmapRecord& record : wall.take()) blocks += record.blocks.size();
  const SurfaceCounters counters = wall.builder.counters();
  EXPECT_EQ(counters.submaps, 12u);
  EXPECT_EQ(counters.blocks_refused + counters.frames_waiting + counters.submaps_dropped, 0u);
  const auto by_anchor = wall.blocks_by_anchor();
  EXPECT_EQ(by_anchor.size(), 12u) << "each is known still";
  std::size_t known = 0;
  for (const auto& [anchor, used] : by_anchor) known += used;
  EXPECT_EQ(known, blocks);
  EXPECT_LT(wall.builder.blocks(), known / 2) << "most of them on the shelf";
}

TEST(SurfaceBuilder, ComingBackOpensTheSubmapAgain) {
  Wall wall;
  const auto walk = [&](std::uint32_t anchor) {
    for (const double step : {0.0, 0.5}) {
      wall.integrate(2.0 * anchor + step, 0, anchor, 2.0 * anchor);
      wall.take();
    }
  };
  for (const std::uint32_t anchor : {0u, 1u, 2u, 3u, 4u}) walk(anchor);
  const std::size_t before = wall.blocks_by_anchor().at(0);
  walk(0);
  EXPECT_EQ(wall.builder.counters().reopened, 1u);
  EXPECT_EQ(wall.blocks_by_anchor().at(0), before) << "it saw nothing new";
  int twice = 0;
  wall.builder.for_each([&](const SubmapAnchor& a, const VoxelMap& voxels) {
    if (a.keyframe != 0) return;
    voxels.for_each([&](const BlockView& block) {
      for (const Voxel& voxel : block.voxels) twice += voxel.weight > 12;  // 4 at two metres, a frame
    });
  });
  EXPECT_GT(twice, 1000) << "and what it had seen counts still";
}

TEST(SurfaceBuilder, ASubmapThatNobodyTakesKeepsItsPlaceAndFramesWait) {
  Wall wall;
  for (int i = 0; i < 6; ++i) wall.integrate(2.0 * i, 0, static_cast<std::uint32_t>(i), 2.0 * i);
  EXPECT_EQ(wall.builder.counters().submaps, 4u);
  EXPECT_EQ(wall.builder.counters().frames_waiting, 2u);
  wall.take();
  EXPECT_TRUE(wall.integrate(12, 0, 6, 12));
}

TEST(SurfaceBuilder, AnAnchorThatMovesTakesItsSubmapAlong) {
  Wall wall;
  wall.integrate(0, 0, 0, 0);
  wall.builder.place(Wall::anchor_at(0, 0.25));
  wall.builder.for_each([&](const SubmapAnchor& anchor, const VoxelMap& voxels) {
    EXPECT_EQ(anchor.T_anchor_robot.inverse().t.x(), 0.25);
    EXPECT_GT(voxels.used(), 0u);
  });
}

}  // namespace
}  // namespace onemap::mapping
