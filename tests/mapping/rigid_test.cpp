#include "mapping/local/rigid.hpp"

#include <gtest/gtest.h>

#include "support/matched_scene.hpp"

namespace onemap::mapping {
namespace {

using test::make_matched_scene;
using test::MatchedScene;

TEST(RigidRansac, RecoversTheMotionAtEveryOutlierRate) {
  RigidRansac ransac({}, 300);
  for (const double outliers : {0.0, 0.25, 0.5, 0.7}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const MatchedScene scene = make_matched_scene(200, outliers, 100 + seed);
      std::vector<std::uint8_t> inlier(200);
      Pose T;
      const RansacResult result = ransac.estimate(scene.r3, scene.s3, inlier, T);
      ASSERT_TRUE(result.ok()) << static_cast<int>(result.reason);
      const auto [right, wrong] = right_and_wrong(scene, inlier);
      const auto good = std::count(scene.good.begin(), scene.good.end(), true);
      EXPECT_EQ(right + wrong, result.inliers);
      EXPECT_GT(right, 0.97 * static_cast<double>(good)) << "outliers " << outliers << " seed " << seed;
      EXPECT_LT(wrong, 5);
      EXPECT_LT((T.t - scene.T_r_s.t).norm(), 0.008);
      EXPECT_LT(test::rotation_angle(T.R.transpose() * scene.T_r_s.R), 0.005);
    }
  }
}

TEST(RigidRansac, ReasonsOfRefusal) {
  RigidRansac ransac({}, 200);
  std::vector<std::uint8_t> inlier(200, 1);
  Pose T;
  MatchedScene scene = make_matched_scene(5, 0, 3);
  EXPECT_EQ(ransac.estimate(scene.r3, scene.s3, inlier, T).reason, RansacReason::too_few_matches);
  std::vector<Vector3d> line;
  for (int i = 0; i < 50; ++i) line.emplace_back(0.01 * i, 0.02 * i - 0.3, 1 + 0.01 * i);
  EXPECT_EQ(ransac.estimate(line, line, inlier, T).reason, RansacReason::degenerate);
  scene = make_matched_scene(100, 1.0, 4);
  EXPECT_EQ(ransac.estimate(scene.r3, scene.s3, inlier, T).reason, RansacReason::too_few_inliers);
  EXPECT_EQ(std::count(inlier.begin() + 100, inlier.end(), 1), 100) << "writes beyond the matches";
}

TEST(RigidRansac, TwoCallsGiveTheSameBits) {
  const MatchedScene scene = make_matched_scene(150, 0.3, 77);
  RigidRansac rigid({}, 150);
  std::vector<std::uint8_t> a(150), b(150);
  Pose S, T;
  rigid.estimate(scene.r3, scene.s3, a, S);
  rigid.estimate(scene.r3, scene.s3, b, T);
  EXPECT_EQ(S.R, T.R);
  EXPECT_EQ(S.t, T.t);
  EXPECT_EQ(a, b);
}

TEST(FitRigid, AgreesWithUmeyamaAndRefusesLines) {
  const MatchedScene scene = make_matched_scene(50, 0, 5);
  Pose T;
  ASSERT_TRUE(fit_rigid(scene.r3, scene.s3, {}, T));
  Eigen::Matrix3Xd r(3, 50), s(3, 50);
  for (int i = 0; i < 50; ++i) {
    r.col(i) = scene.r3[static_cast<std::size_t>(i)];
    s.col(i) = scene.s3[static_cast<std::size_t>(i)];
  }
  const Eigen::Matrix4d judge = Eigen::umeyama(s, r, false);
  EXPECT_LT((T.R - judge.topLeftCorner<3, 3>()).norm(), 1e-9);
  EXPECT_LT((T.t - judge.topRightCorner<3, 1>()).norm(), 1e-9);

  std::vector<std::uint8_t> use(50, 0);
  use[3] = use[7] = 1;
  EXPECT_FALSE(fit_rigid(scene.r3, scene.s3, use, T));  // two points
  std::vector<Vector3d> line;
  for (int i = 0; i < 9; ++i) line.emplace_back(i, 2 * i, 1 - i);
  EXPECT_FALSE(fit_rigid(line, line, {}, T));
}

}  // namespace
}  // namespace onemap::mapping
