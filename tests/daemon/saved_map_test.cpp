#include "daemon/saved_map.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "mapping/local/surface.hpp"
#include "support/random.hpp"

namespace onemap::daemon {
namespace {

using testing::HasSubstr;

// A coloured ball of 30 cm at the origin.
mapping::VoxelMap ball() {
  mapping::VoxelMapConfig config;
  config.budget_bytes = 8u << 20;
  config.image_pixels = 0;
  mapping::VoxelMap map(config);
  for (int z = -3; z < 3; ++z)
    for (int y = -3; y < 3; ++y)
      for (int x = -3; x < 3; ++x)
        for (int i = 0; i < mapping::kBlockVoxels; ++i) {
          const mapping::Vector3d p(8 * x + i % 8 + 0.5, 8 * y + i / 8 % 8 + 0.5, 8 * z + i / 64 + 0.5);
          const double units = ((p * 0.02).norm() - 0.3) / 0.06 * mapping::kTsdfOne;
          if (std::abs(units) > mapping::kTsdfOne) continue;
          mapping::Voxel& voxel = map.find_or_add({x, y, z})[i];
          voxel.add_tsdf(static_cast<int>(units), 5);
          voxel.add_color(200, 10 * (x + 10), i % 256);
        }
  return map;
}

SavedPath way(const std::string& name, std::size_t number) {
  SavedPath path;
  path.name = name;
  path.color = render::robot_color(number);
  path.T_map_robot.t_10um = {100'000, 0, 0};
  for (int i = 0; i < 5; ++i) {
    mapping::QuantizedPose pose;
    pose.t_10um = {0, i * 1000, 0};
    path.poses.push_back(pose);
    if (i % 2 == 0) path.keyframes.push_back(pose);
  }
  return path;
}

std::vector<std::uint8_t> saved() {
  const std::vector<SavedPath> paths{way("r1", 0), way("r2", 4)};
  return save_map("the ball", paths, ball());
}

TEST(SavedMap, GivesBackTheSurfaceOfTheMap) {
  const auto scene = load_map("ball.omap", saved());
  ASSERT_TRUE(scene) << scene.error().text();
  const mapping::TriangleMesh expected = mapping::extract_mesh(ball());
  ASSERT_GT(expected.vertices.size(), 1000u);
  // A record's voxels are in steps, so the surface is a part of a millimetre off.
  const auto count = static_cast<double>(expected.vertices.size());
  EXPECT_NEAR(static_cast<double>(scene->mesh.vertices.size()), count, 0.02 * count);
  double worst = 0, mean_red = 0;
  for (std::size_t i = 0; i < scene->mesh.vertices.size(); ++i) {
    double nearest = 1;
    for (const auto& v : expected.vertices) nearest = std::min<double>(nearest, (scene->mesh.vertices[i] - v).norm());
    worst = std::max(worst, nearest);
    mean_red += scene->mesh.colors[i][0];
  }
  EXPECT_LT(worst, 0.003);
  double expected_red = 0;
  for (const auto& color : expected.colors) expected_red += color[0];
  EXPECT_NEAR(mean_red / static_cast<double>(scene->mesh.colors.size()), expected_red / count, 4);
  EXPECT_EQ(scene->title, "the ball");
}

TEST(SavedMap, GivesBackTheRobotsWaysInTheMapsFrame) {
  const auto scene = load_map("ball.omap", saved());
  ASSERT_EQ(scene->robots.size(), 2u);
  EXPECT_EQ(scene->robots[1].name, "r2");
  EXPECT_EQ(scene->robots[1].color, render::robot_color(4));
  ASSERT_EQ(scene->robots[1].poses.size(), 5u);
  ASSERT_EQ(scene->robots[1].keyframe_poses.size(), 3u);
  EXPECT_DOUBLE_EQ(scene->robots[1].poses[4].t.x(), 1.0);
  EXPECT_DOUBLE_EQ(scene->robots[1].poses[4].t.y(), 0.04);
}

TEST(SavedMap, GivesBackWhichWayIsUp) {
  EXPECT_FALSE(load_map("x", saved())->up) << "it was not said";
  const auto scene = load_map("x", save_map("", {}, ball(), mapping::UpDirection{{0, 600'000, 800'000}}));
  ASSERT_TRUE(scene);
  EXPECT_LT((*scene->up - mapping::Vector3f(0, 0.6f, 0.8f)).norm(), 1e-5f);
  const auto bad = load_map("x", save_map("", {}, ball(), mapping::UpDirection{{0, 0, 800'000}}));
  EXPECT_THAT(bad.error().text(), HasSubstr("a way up that cannot be"));
}

TEST(SavedMap, AnEmptyMapIsAMap) {
  mapping::VoxelMapConfig config;
  config.budget_bytes = 4u << 20;
  const auto scene = load_map("x", save_map("", {}, mapping::VoxelMap(config)));
  ASSERT_TRUE(scene);
  EXPECT_TRUE(scene->mesh.vertices.empty());
}

TEST(SavedMap, WhatIsCutShortIsRefusedWithThePlace) {
  const auto whole = saved();
  for (std::size_t size = 0; size < whole.size(); size += size < 400 ? 1 : 997) {
    const auto scene = load_map("ball.omap", std::span(whole).first(size));
    ASSERT_FALSE(scene) << size;
    EXPECT_THAT(scene.error().text(), HasSubstr("ball.omap"));
  }
  auto longer = whole;
  longer.push_back(0);
  EXPECT_THAT(load_map("x", longer).error().text(), HasSubstr("goes on after its end"));
  EXPECT_THAT(load_map("x", std::vector<std::uint8_t>{1, 2, 3}).error().text(), HasSubstr("not a saved map"));
}

// Sections are tag u8, size u32, content; the grid is the first one, its third number says how many blocks there are.
TEST(SavedMap, MoreBlocksThanItSaidAndABlockTwiceAreRefused) {
  const auto whole = saved();
  std::vector<std::uint8_t> submaps;
  for (std::size_t at = 8; whole[at] != 0;) {
    const std::size_t size = 5 + whole[at + 1] + 256u * whole[at + 2] + 65536u * whole[at + 3];
    if (whole[at] == 4) submaps.insert(submaps.end(), &whole[at], &whole[at] + size);
    at += size;
  }
  auto twice = whole;
  twice.insert(twice.end() - 5, submaps.begin(), submaps.end());
  EXPECT_THAT(load_map("x", twice).error().text(), HasSubstr("more blocks than it said"));
  twice[8 + 5 + 8 + 2] = 1;  // 65536 more
  EXPECT_THAT(load_map("x", twice).error().text(), HasSubstr("a block that is there twice"));
}

TEST(SavedMap, DamagedBytesGiveAMapOrAReason) {
  const auto whole = saved();
  test::Random random(7);
  int refused = 0;
  for (int k = 0; k < 300; ++k) {
    auto damaged = whole;
    for (int n = 0; n < 3; ++n)
      damaged[random.next() % (k % 2 == 0 ? 600 : damaged.size())] ^=
          static_cast<std::uint8_t>(1u << (random.next() % 8));
    const auto scene = load_map("x", damaged);
    refused += scene ? 0 : 1;
  }
  EXPECT_GT(refused, 100);
}

TEST(SavedMap, NamesFromOutsideAreMadePrintable) {
  const std::vector<SavedPath> paths{way("r\x1b[31m", 0)};
  EXPECT_EQ(load_map("x", save_map("a\nb", paths, ball()))->robots[0].name, "r\\x1b[31m");
}

}  // namespace
}  // namespace onemap::daemon
