#include "mapping/team/free_space.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/box_room.hpp"
#include "support/kinect_lens.hpp"
#include "support/simulated_keyframes.hpp"

namespace onemap::mapping {
namespace {

// A grid that sees one plane, z_m ahead, with its pinhole in the middle.
DepthGrid wall_ahead(double z_m) {
  DepthGrid grid;
  grid.width = 160, grid.height = 120;
  grid.fx_fy_cx_cy = {131 << 10, 131 << 10, (80 << 10) - 512, (60 << 10) - 512};
  grid.inverse_depth.assign(std::size_t{160} * 120, grid_inverse_depth(z_m));
  return grid;
}

std::vector<std::uint8_t> bytes_of(const FreeSpace& space) {
  std::vector<std::uint8_t> out;
  space.for_each_sorted([&](const BlockKey& key, FreeSpace::BlockVotes votes) {
    for (const std::int32_t k : {key.x, key.y, key.z})
      for (int i = 0; i < 4; ++i) out.push_back(static_cast<std::uint8_t>(k >> (8 * i)));
    for (const CellVotes v : votes) out.insert(out.end(), {v.seen_through, v.hit});
  });
  return out;
}

TEST(FreeSpace, AWallIsHitWhatIsBeforeItSeenThroughAndWhatIsBehindItUnknown) {
  FreeSpace space({});
  const DepthGrid grid = wall_ahead(2.02);
  const Pose pose{test::rotation({1, 2, 3}, 0.7), {3, -4, 5}};
  for (int i = 0; i < 2; ++i) space.carve(grid, pose);
  for (double z = 0.15; z < 3.5; z += 0.01) {
    const Space seen = space.at(pose * Vector3d(0.05 * z, -0.1 * z, z));
    if (z < 1.90) {
      EXPECT_EQ(seen, Space::empty) << z;
    } else if (z < 2.02 - 0.09) {  // a cell's diagonal: no cell of the wall begins here
      EXPECT_NE(seen, Space::occupied) << z;
    } else if (z > 2.015 && z < 2.025) {
      EXPECT_EQ(seen, Space::occupied) << z;
    } else if (z > 2.02 + 0.09) {
      EXPECT_EQ(seen, Space::unknown) << z;
    }
  }
  EXPECT_EQ(space.at(pose * Vector3d(1.5, 0, 1)), Space::unknown) << "outside the view";
  EXPECT_EQ(space.at(pose * Vector3d(0, 0, -1)), Space::unknown) << "behind the camera";
  EXPECT_EQ(space.counters().keyframes, 2u);
  EXPECT_EQ(space.counters().votes_refused, 0u);
}

TEST(FreeSpace, PixelsWithoutDepthAndBeyondReachSayNoMoreThanTheyKnow) {
  DepthGrid grid = wall_ahead(6);
  for (std::size_t i = 0; i < grid.inverse_depth.size(); ++i)
    if (i % 160 < 80) grid.inverse_depth[i] = 0;
  FreeSpace space({});
  for (int i = 0; i < 2; ++i) space.carve(grid, {});
  EXPECT_EQ(space.at({-0.3, 0, 2}), Space::unknown) << "no depth there";
  EXPECT_EQ(space.at({0.3, 0, 2}), Space::empty);
  EXPECT_EQ(space.at({0.3, 0, 3.9}), Space::empty);
  EXPECT_EQ(space.at({0.3, 0, 4.1}), Space::unknown) << "beyond reach_m";
  EXPECT_EQ(space.at({0.3, 0, 6}), Space::unknown) << "a hit that far is not counted";
  FreeSpace near({});
  for (int i = 0; i < 2; ++i) near.carve(wall_ahead(3.7), {});
  EXPECT_EQ(near.at({0.3, 0, 3.7}), Space::unknown) << "nor is one whose height is not sure";
  EXPECT_EQ(near.at({0.3, 0, 3.4}), Space::empty);
}

TEST(FreeSpace, OneKeyframeHasOneVoteAndOneVoteIsNotEnough) {
  FreeSpace space({});
  space.carve(wall_ahead(1.02), {});
  const CellVotes wall = space.votes({0, 0, 20}), air = space.votes({0, 0, 10});
  EXPECT_EQ(wall.hit, 1) << "though some sixty pixels hit it";
  EXPECT_EQ(wall.seen_through, 0);
  EXPECT_EQ(air.seen_through, 1);
  EXPECT_EQ(space.at({0.02, 0.02, 1.02}), Space::unknown);
  for (int i = 0; i < 400; ++i) space.carve(wall_ahead(1.02), {});
  EXPECT_EQ(space.votes({0, 0, 20}).hit, 255) << "counts stop, they do not wrap";
}

TEST(FreeSpace, WhoPassesByIsForgottenAndWhatStaysIsNot) {
  EXPECT_EQ(judged({0, 0}), Space::unknown);
  EXPECT_EQ(judged({1, 0}), Space::unknown);
  EXPECT_EQ(judged({2, 0}), Space::empty);
  EXPECT_EQ(judged({0, 1}), Space::unknown);
  EXPECT_EQ(judged({8, 2}), Space::occupied);
  EXPECT_EQ(judged({9, 2}), Space::empty);
  EXPECT_EQ(judged({4, 1}), Space::unknown);
  FreeSpace space({});
  for (int i = 0; i < 3; ++i) space.carve(wall_ahead(1.02), {});  // somebody's back
  EXPECT_EQ(space.at({0.02, 0.02, 1.02}), Space::occupied);
  for (int i = 0; i < 20; ++i) space.carve(wall_ahead(3.02), {});
  EXPECT_EQ(space.at({0.02, 0.02, 1.02}), Space::empty);
  EXPECT_EQ(space.at({0.02, 0.02, 3.02}), Space::occupied);
}

// The rays of the slow way: through every pixel in small steps until just before its point.
TEST(FreeSpace, AgreesWithWalkingAlongEveryRayInARoom) {
  const hal::Intrinsics k = test::kinect_lens();
  const RayTable rays(k);
  const auto scene = test::box_room();
  const FreeSpaceConfig config;
  FreeSpace space(config);
  const Pose pose{test::rotation({0, 1, 0.2}, 0.4), {0.3, 0.1, -0.2}};
  const DepthGrid grid = test::depth_grid(test::cast_depth(scene, k, rays, pose), k);
  space.carve(grid, pose);
  const auto& f = grid.fx_fy_cx_cy;
  int walked = 0, through = 0;
  // Not near the view's edge, where the middle of a cell may be outside it.
  for (int v = 8; v < grid.height - 8; v += 3)
    for (int u = 8; u < grid.width - 8; u += 3) {
      const double z_m = grid_depth_m(grid.inverse_depth[static_cast<std::size_t>(v * grid.width + u)]);
      for (double z = 0.5; z < std::min(z_m - 0.25, config.reach_m - 0.1); z += 0.05) {
        const Vector3d p = pose * (z * Vector3d((u * 1024.0 - f[2]) / f[0], (v * 1024.0 - f[3]) / f[1], 1));
        const BlockKey cell{static_cast<std::int32_t>(std::floor(p.x() / config.cell_m)),
                            static_cast<std::int32_t>(std::floor(p.y() / config.cell_m)),
                            static_cast<std::int32_t>(std::floor(p.z() / config.cell_m))};
        ++walked;
        through += space.votes(cell).seen_through;
      }
    }
  ASSERT_GT(walked, 20000);
  EXPECT_GT(through, walked * 98 / 100);
  int wrong = 0, cells = 0;  // and no cell that is seen through lies in or behind a wall
  space.for_each_sorted([&](const BlockKey& key, FreeSpace::BlockVotes votes) {
    for (int i = 0; i < kBlockVoxels; ++i) {
      if (votes[static_cast<std::size_t>(i)].seen_through == 0) continue;
      const Vector3d p =
          config.cell_m * Vector3d(key.x * 8 + i % 8 + 0.5, key.y * 8 + i / 8 % 8 + 0.5, key.z * 8 + i / 64 + 0.5);
      ++cells;
      wrong += std::ranges::any_of(scene, [&](const test::Plane& plane) { return plane.n.dot(p) > plane.h; });
    }
  });
  EXPECT_GT(cells, 10000);
  EXPECT_EQ(wrong, 0);
}

TEST(FreeSpace, AnyOrderOfKeyframesGivesTheSameBytes) {
  const auto keyframes = test::simulated_keyframes("simulated:office?frames=60&width=320&height=240", 5);
  FreeSpace forward({}), backward({});
  for (std::size_t i = 0; i < keyframes.grids.size(); ++i) {
    forward.carve(keyframes.grids[i], keyframes.poses[i]);
    const std::size_t j = keyframes.grids.size() - 1 - i;
    backward.carve(keyframes.grids[j], keyframes.poses[j]);
  }
  EXPECT_GT(forward.used(), 100u);
  EXPECT_EQ(bytes_of(forward), bytes_of(backward));
}

TEST(FreeSpace, AFullGridKeepsWhatItHasAndCountsWhatItRefuses) {
  FreeSpaceConfig config;
  config.budget_bytes = 100'000;
  FreeSpace space(config);
  EXPECT_GT(space.capacity(), 50u);
  EXPECT_LE(space.bytes(), config.budget_bytes);
  for (int i = 0; i < 3; ++i) space.carve(wall_ahead(1.02), {});
  EXPECT_EQ(space.counters().votes_refused, 0u);
  for (int i = 0; i < 3; ++i) space.carve(wall_ahead(3.5), {});
  EXPECT_EQ(space.used(), space.capacity());
  EXPECT_GT(space.counters().votes_refused, 10000u);
  EXPECT_EQ(space.votes({0, 0, 20}).hit, 3) << "what came first";
  EXPECT_EQ(space.votes({0, 0, 20}).seen_through, 3) << "is still voted about";
  FreeSpace none(FreeSpaceConfig{.budget_bytes = 0});
  none.carve(wall_ahead(2), {});
  EXPECT_EQ(none.used(), 0u);
  EXPECT_EQ(none.at({0, 0, 1}), Space::unknown);
}

TEST(FreeSpace, WhatNoCameraSeesIsRefusedAndCounted) {
  FreeSpace space({});
  space.carve({}, {});
  DepthGrid torn = wall_ahead(2);
  torn.inverse_depth.pop_back();
  space.carve(torn, {});
  DepthGrid wide = wall_ahead(2);
  wide.fx_fy_cx_cy[0] = 1;  // a view of 180 degrees: its far end would be kilometres away
  space.carve(wide, {});
  DepthGrid aside = wall_ahead(2);
  aside.fx_fy_cx_cy[3] = std::numeric_limits<std::int32_t>::min();
  space.carve(aside, {});
  space.carve(wall_ahead(2), {Matrix3d::Identity(), {2e6, 0, 0}});
  space.carve(wall_ahead(2), {Matrix3d::Identity(), {std::nan(""), 0, 0}});
  EXPECT_EQ(space.counters().keyframes_refused, 6u);
  EXPECT_EQ(space.counters().keyframes, 0u);
  EXPECT_EQ(space.used(), 0u);
  EXPECT_EQ(space.at({std::nan(""), 0, 0}), Space::unknown);
}

}  // namespace
}  // namespace onemap::mapping
