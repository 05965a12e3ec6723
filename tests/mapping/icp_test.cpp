#include "mapping/local/icp.hpp"

#include <gtest/gtest.h>

#include "mapping/local/voxel_grid.hpp"
#include "support/box_room.hpp"
#include "support/tum_recording.hpp"

namespace onemap::mapping {
namespace {

constexpr int kWidth = 160, kHeight = 120;

std::vector<Vector3f> downsampled(const OrganizedCloud& cloud, float leaf_m, float max_depth_m = kMaxDepth_m) {
  std::vector<Vector3f> valid, out(cloud.points.size());
  for (const auto& p : cloud.points) {
    if (p.z() > 0 && p.z() <= max_depth_m) valid.push_back(p);
  }
  VoxelGrid grid(leaf_m, cloud.points.size());
  out.resize(grid.downsample(valid, out));
  return out;
}

struct Pair {
  OrganizedCloud target, source;
};

Pair cast_pair(const std::vector<test::Plane>& scene, const Pose& T_world_target, const Pose& T_world_source,
               test::Random* noise, const hal::DepthNoise& model = {}) {
  const hal::Intrinsics k;
  static const RayTable rays(k);
  Pair pair;
  organize(test::cast_depth(scene, k, rays, T_world_target, noise, model), k, kWidth, kHeight, pair.target);
  organize(test::cast_depth(scene, k, rays, T_world_source, noise, model), k, kWidth, kHeight, pair.source);
  return pair;
}

TEST(Icp, FindsTheMotionInARoomOfPlanes) {
  for (const bool noisy : {false, true}) {
    test::Random random(12), noise(99);
    for (int i = 0; i < 5; ++i) {
      Pose target;
      target.R = test::rotation({1, 2, 1}, 0.7);
      const Pose motion = test::random_pose(random, 0.04, 0.03);
      const Pair pair = cast_pair(test::box_room(), target, target * motion, noisy ? &noise : nullptr);
      const IcpResult result = Icp({}).align(pair.target, downsampled(pair.source, 0.05f), Pose{});
      EXPECT_TRUE(result.converged) << static_cast<int>(result.reason);
      EXPECT_EQ(result.reason, IcpReason::converged);
      EXPECT_GT(result.inliers, 500);
      EXPECT_LT((result.T_target_source.t - motion.t).norm(), noisy ? 0.005 : 0.002);
      EXPECT_LT(test::rotation_angle(result.T_target_source.R.transpose() * motion.R), noisy ? 0.0025 : 0.001);
      EXPECT_LT(result.error_m, noisy ? 0.012 : 0.008);
      EXPECT_LT(result.gradient.norm(), 1e-3 * result.information.norm());
    }
  }
}

TEST(Icp, ACorrespondenceWeighsWhatItsCamerasNoiseSays) {
  constexpr hal::DepthNoise kFlat{0.002, 0, 0}, kTwice{0.004, 0, 0}, kGrowing{0.001, 0.004, 0};
  const Pair pair = cast_pair(test::box_room(), {}, {}, nullptr);
  const auto source = downsampled(pair.source, 0.05f);
  const auto aligned = [&](const hal::DepthNoise& noise) {
    OrganizedCloud target = pair.target;
    target.noise = noise;
    return Icp({}).align(target, source, Pose{});
  };
  const IcpResult flat = aligned(kFlat), twice = aligned(kTwice), growing = aligned(kGrowing);
  // Exact depth: no residual of a wall is near the robust scale, so the weights are 1 / sigma^2.
  EXPECT_NEAR(flat.weight / flat.inliers, 1 / (0.002 * 0.002), 0.05 / (0.002 * 0.002));
  EXPECT_NEAR(twice.weight / twice.inliers, 1 / (0.004 * 0.004), 0.05 / (0.004 * 0.004));
  double expected = 0;
  for (const Vector3f& p : source) expected += std::pow(kGrowing.sigma_m(static_cast<double>(p.z())), -2);
  EXPECT_NEAR(growing.weight, expected, 0.1 * expected);
  EXPECT_EQ(aligned({}).weight, Icp({}).align(pair.target, source, Pose{}).weight) << "a Kinect when nobody says";
}

TEST(Icp, ASinglePlaneIsDegenerate) {
  test::Random noise(4);
  for (const bool noisy : {false, true}) {
    const Pair pair = cast_pair({{{0.2, 0.1, 1}, 1.5}}, {}, {}, noisy ? &noise : nullptr);
    const IcpResult result = Icp({}).align(pair.target, downsampled(pair.source, 0.05f), Pose{});
    EXPECT_FALSE(result.converged);
    EXPECT_EQ(result.reason, IcpReason::degenerate);
  }
}

TEST(Icp, TwoWallsLeaveOneDirectionOpen) {
  test::Random noise(4);
  const Pair pair = cast_pair({{{0.8, 0, 1}, 1.8}, {{-0.8, 0, 1}, 1.8}}, {}, {}, &noise);
  EXPECT_EQ(Icp({}).align(pair.target, downsampled(pair.source, 0.05f), Pose{}).reason, IcpReason::degenerate);
}

TEST(Icp, TooFewPointsAndEmptyClouds) {
  const Pair pair = cast_pair(test::box_room(), {}, {}, nullptr);
  const auto source = downsampled(pair.source, 0.05f);
  EXPECT_EQ(Icp({}).align(pair.target, std::span(source).first(50), Pose{}).reason, IcpReason::too_few_inliers);
  EXPECT_EQ(Icp({}).align(pair.target, {}, Pose{}).reason, IcpReason::too_few_inliers);
  Pose behind;
  behind.t.z() = -20;
  EXPECT_EQ(Icp({}).align(pair.target, source, behind).inliers, 0);
  EXPECT_EQ(Icp({}).align(OrganizedCloud{}, source, Pose{}).reason, IcpReason::too_few_inliers);
}

TEST(Icp, TwoCallsGiveTheSameBits) {
  test::Random random(1), noise(2);
  const Pair pair = cast_pair(test::box_room(), {}, test::random_pose(random, 0.03, 0.03), &noise);
  const auto source = downsampled(pair.source, 0.05f);
  const IcpResult a = Icp({}).align(pair.target, source, Pose{}), b = Icp({}).align(pair.target, source, Pose{});
  EXPECT_EQ(a.T_target_source.R, b.T_target_source.R);
  EXPECT_EQ(a.T_target_source.t, b.T_target_source.t);
  EXPECT_EQ(a.information, b.information);
  EXPECT_EQ(a.iterations, b.iterations);
}

// Medians over pairs of recorded frames, against motion capture; the bounds are what PCL's GICP reaches at 5 cm.
TEST(Icp, RecordedPairsAreWithinGicpsErrors) {
  const std::filesystem::path folder = std::filesystem::path(ONEMAP_SHARED_DIR) / "data/fr1_xyz";
  if (!std::filesystem::exists(folder / "depth.txt")) GTEST_SKIP() << "recording not found: " << folder;
  const test::TumRecording recording(folder);
  ASSERT_TRUE(recording.ok());
  struct Bound {
    std::size_t gap;
    double translation_m, rotation_deg;
  };
  for (const Bound& bound : {Bound{1, 0.0029, 0.35}, Bound{5, 0.0061, 0.70}, Bound{10, 0.0106, 0.85}}) {
    std::vector<double> translation_m, rotation_deg;
    for (std::size_t i = 0; i + bound.gap < recording.depths().size(); i += 10) {
      Pose a, b;
      if (!recording.truth(i, a) || !recording.truth(i + bound.gap, b)) continue;
      OrganizedCloud target, source;
      organize(recording.depth(i), recording.intrinsics(), kWidth, kHeight, target);
      organize(recording.depth(i + bound.gap), recording.intrinsics(), kWidth, kHeight, source);
      const IcpResult result = Icp({}).align(target, downsampled(source, 0.05f, 5), Pose{});
      const Pose error = (a.inverse() * b).inverse() * result.T_target_source;
      translation_m.push_back(error.t.norm());
      rotation_deg.push_back(test::rotation_angle(error.R) * 57.29578);
    }
    const auto median = [](std::vector<double>& v) {
      std::sort(v.begin(), v.end());
      return v[v.size() / 2];
    };
    ASSERT_GT(translation_m.size(), 30u);
    EXPECT_LE(median(translation_m), bound.translation_m) << "gap " << bound.gap;
    EXPECT_LE(median(rotation_deg), bound.rotation_deg) << "gap " << bound.gap;
  }
}

}  // namespace
}  // namespace onemap::mapping
