#include "mapping/local/mapper_config.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "mapping/records/submap.hpp"

namespace onemap::mapping {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN(), kInfinity = std::numeric_limits<double>::infinity();

struct Case {
  LocalMapperConfig config;
  hal::Intrinsics camera;
};

// The place that check() names; "" when it accepts.
std::string refused(const std::function<void(Case&)>& change) {
  Case c;
  change(c);
  const Status status = check(c.config, c.camera);
  if (status.ok()) return "";
  EXPECT_FALSE(status.error().reason.empty());
  return status.error().place;
}

TEST(MapperConfig, TheDefaultsAreAccepted) {
  EXPECT_EQ(refused([](Case&) {}), "");
}

TEST(MapperConfig, KeyframePoolsBelowTheLeastAreRefused) {
  for (const int n : {-1, 0, 2, 8, kMinKeyframes - 1})
    EXPECT_EQ(refused([n](Case& c) { c.config.max_keyframes = n; }), "max_keyframes") << n;
  EXPECT_EQ(refused([](Case& c) { c.config.max_keyframes = kMinKeyframes; }), "");
}

TEST(MapperConfig, WhatIsNotANumberIsInNoRange) {
  for (const double bad : {kNaN, kInfinity, -kInfinity}) {
    const auto f = static_cast<float>(bad);
    EXPECT_EQ(refused([&](Case& c) { c.config.keyframe_translation_m = bad; }), "keyframe_translation_m");
    EXPECT_EQ(refused([&](Case& c) { c.config.keyframe_rotation_deg = bad; }), "keyframe_rotation_deg");
    EXPECT_EQ(refused([&](Case& c) { c.config.min_motion_m = bad; }), "min_motion_m");
    EXPECT_EQ(refused([&](Case& c) { c.config.min_motion_deg = bad; }), "min_motion_deg");
    EXPECT_EQ(refused([&](Case& c) { c.config.map.voxel_m = f; }), "map.voxel_m");
    EXPECT_EQ(refused([&](Case& c) { c.config.map.truncation_m = f; }), "map.truncation_m");
    EXPECT_EQ(refused([&](Case& c) { c.config.map.max_depth_m = f; }), "map.max_depth_m");
    EXPECT_EQ(refused([&](Case& c) { c.camera.fx = bad; }), "camera.fx");
    EXPECT_EQ(refused([&](Case& c) { c.camera.fy = bad; }), "camera.fy");
    EXPECT_EQ(refused([&](Case& c) { c.camera.cx = bad; }), "camera.cx");
    EXPECT_EQ(refused([&](Case& c) { c.camera.cy = bad; }), "camera.cy");
    EXPECT_EQ(refused([&](Case& c) { c.camera.depth_scale = bad; }), "camera.depth_scale");
    for (double hal::Intrinsics::*k :
         {&hal::Intrinsics::k1, &hal::Intrinsics::k2, &hal::Intrinsics::p1, &hal::Intrinsics::p2, &hal::Intrinsics::k3})
      EXPECT_EQ(refused([&](Case& c) { c.camera.*k = bad; }), "camera.k1 k2 p1 p2 k3");
  }
}

TEST(MapperConfig, BoundsAreOfBothSides) {
  EXPECT_EQ(refused([](Case& c) { c.config.max_features = 49; }), "max_features");
  EXPECT_EQ(refused([](Case& c) { c.config.max_features = 1001; }), "max_features");
  EXPECT_EQ(refused([](Case& c) { c.config.max_keyframes = 10001; }), "max_keyframes");
  EXPECT_EQ(refused([](Case& c) { c.config.keyframe_translation_m = 6; }), "keyframe_translation_m");
  EXPECT_EQ(refused([](Case& c) { c.config.keyframe_rotation_deg = 91; }), "keyframe_rotation_deg");
  EXPECT_EQ(refused([](Case& c) { c.config.min_motion_m = -0.1; }), "min_motion_m");
  EXPECT_EQ(refused([](Case& c) { c.config.min_motion_deg = 46; }), "min_motion_deg");
  EXPECT_EQ(refused([](Case& c) { c.config.map.max_depth_m = 9; }), "map.max_depth_m");
  EXPECT_EQ(refused([](Case& c) { c.config.map.voxel_m = 0.0009f; }), "map.voxel_m");
  EXPECT_EQ(refused([](Case& c) { c.config.map.voxel_m = 1.1f; }), "map.voxel_m");
}

// Whatever is accepted here makes submaps that every decoder takes.
TEST(MapperConfig, TruncationIsWhatRecordsCanSay) {
  int accepted = 0, refusals = 0;
  for (float voxel_m = 0.001f; voxel_m <= 1; voxel_m *= 1.37f)
    for (const float voxels : {0.5f, 1.9f, 2.0f, 3.0f, 99.9f, 100.0f, 100.1f, 1000.0f}) {
      Case c;
      c.config.map.voxel_m = voxel_m;
      c.config.map.truncation_m = voxels * voxel_m;
      if (!check(c.config, c.camera)) {
        ++refusals;
        EXPECT_TRUE(voxels < 2.01f || voxels > 99.99f) << voxels << " voxels of " << voxel_m;
        continue;
      }
      ++accepted;
      EXPECT_TRUE(voxels > 1.99f && voxels < 100.05f) << voxels << " voxels of " << voxel_m;
      SubmapRecord submap;
      submap.voxel_um = c.config.map.voxel_um();
      submap.truncation_um = c.config.map.truncation_um();
      EXPECT_TRUE(decode_submap(encode(submap)).ok()) << voxels << " voxels of " << voxel_m;
    }
  EXPECT_GT(accepted, 40);
  EXPECT_GT(refusals, 80);
}

TEST(MapperConfig, ABudgetHoldsAtLeastOneBlockBesideTheImage) {
  const auto with_budget = [](std::size_t bytes) {
    return refused([bytes](Case& c) { c.config.map.budget_bytes = bytes; });
  };
  EXPECT_EQ(with_budget(0), "map.budget_bytes");
  EXPECT_EQ(with_budget(2 << 20), "map.budget_bytes") << "the images of 640x480 take 2.4 MB";
  EXPECT_EQ(with_budget(4 << 20), "");
  EXPECT_EQ(with_budget(~std::size_t{0}), "map.budget_bytes");
}

TEST(MapperConfig, CamerasThatAreNoneAreRefused) {
  EXPECT_EQ(refused([](Case& c) { c.camera.fx = 1e300; }), "camera.fx");
  EXPECT_EQ(refused([](Case& c) { c.camera.fy = 0; }), "camera.fy");
  EXPECT_EQ(refused([](Case& c) { c.camera.fx = -525; }), "camera.fx");
  EXPECT_EQ(refused([](Case& c) { c.camera.cx = 640; }), "camera.cx");
  EXPECT_EQ(refused([](Case& c) { c.camera.cy = -1; }), "camera.cy");
  EXPECT_EQ(refused([](Case& c) { c.camera.width = 0; }), "camera.width");
  EXPECT_EQ(refused([](Case& c) { c.camera.height = 5000; }), "camera.height");
  EXPECT_EQ(refused([](Case& c) {
              c.camera.width = c.camera.height = 4096;
              c.camera.fx = c.camera.fy = 4000;
              c.config.map.budget_bytes = 1u << 30;
            }),
            "camera.width");
  EXPECT_EQ(refused([](Case& c) { c.camera.depth_scale = 0; }), "camera.depth_scale");
  EXPECT_EQ(refused([](Case& c) { c.camera.k1 = -5; }), "camera.k1 k2 p1 p2 k3");
}

TEST(MapperConfig, TheCalibrationOfAKinectIsAccepted) {
  EXPECT_EQ(refused([](Case& c) {
              c.camera = {.fx = 517.306408,
                          .fy = 516.469215,
                          .cx = 318.643040,
                          .cy = 255.313989,
                          .k1 = 0.262383,
                          .k2 = -0.953104,
                          .p1 = -0.005358,
                          .p2 = 0.002628,
                          .k3 = 1.163314};
            }),
            "");
}

}  // namespace
}  // namespace onemap::mapping
