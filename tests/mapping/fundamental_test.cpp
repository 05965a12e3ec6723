#include "mapping/local/fundamental.hpp"

#include <gtest/gtest.h>

#include "support/matched_scene.hpp"

namespace onemap::mapping {
namespace {

using test::make_matched_scene;
using test::MatchedScene;

TEST(FundamentalRansac, FindsTheTrueInliersAtEveryOutlierRate) {
  FundamentalRansac ransac({.max_iterations = 1000}, 300);
  for (const double outliers : {0.0, 0.1, 0.25, 0.4}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const MatchedScene scene = make_matched_scene(200, outliers, seed);
      std::vector<std::uint8_t> inlier(200);
      Matrix3d F;
      const RansacResult result = ransac.estimate(scene.r2, scene.s2, inlier, F);
      ASSERT_TRUE(result.ok()) << static_cast<int>(result.reason);
      const auto [right, wrong] = right_and_wrong(scene, inlier);
      EXPECT_EQ(right + wrong, result.inliers);
      const auto good = std::count(scene.good.begin(), scene.good.end(), true);
      EXPECT_GT(right, 0.9 * static_cast<double>(good)) << "outliers " << outliers << " seed " << seed;
      EXPECT_LT(wrong, 0.1 * static_cast<double>(200 - good) + 1);
      EXPECT_NEAR(F.norm(), 1, 1e-12);
      EXPECT_NEAR(F.determinant(), 0, 1e-9);
    }
  }
}

TEST(FundamentalRansac, ExactPointsGiveTheEssentialMatrixOfTheMotion) {
  const MatchedScene scene = make_matched_scene(60, 0, 9, false);
  FundamentalRansac ransac({}, 60);
  std::vector<std::uint8_t> inlier(60);
  Matrix3d F;
  ASSERT_TRUE(ransac.estimate(scene.r2, scene.s2, inlier, F).ok());
  const Vector3d& t = scene.T_r_s.t;
  Matrix3d cross;
  cross << 0, -t.z(), t.y(), t.z(), 0, -t.x(), -t.y(), t.x(), 0;
  Matrix3d E = cross * scene.T_r_s.R;  // x_r^T [t]x R x_s = 0
  E /= E.norm();
  if ((E - F).norm() > 1) E = -E;
  EXPECT_LT((E - F).norm(), 1e-6);
}

TEST(FundamentalRansac, ReasonsOfRefusal) {
  FundamentalRansac ransac({}, 200);
  std::vector<std::uint8_t> inlier(200, 1);
  Matrix3d F;
  MatchedScene scene = make_matched_scene(10, 0, 3);
  EXPECT_EQ(ransac.estimate(scene.r2, scene.s2, inlier, F).reason, RansacReason::too_few_matches);
  std::vector<Eigen::Vector2d> line;
  for (int i = 0; i < 50; ++i) line.emplace_back(0.01 * i, 0.02 * i - 0.3);
  EXPECT_EQ(ransac.estimate(line, line, inlier, F).reason, RansacReason::degenerate);
  scene = make_matched_scene(100, 1.0, 4);
  EXPECT_EQ(FundamentalRansac({.min_inliers = 60}, 200).estimate(scene.r2, scene.s2, inlier, F).reason,
            RansacReason::too_few_inliers);
}

TEST(FundamentalRansac, ACameraThatDidNotMoveKeepsItsMatches) {
  const MatchedScene scene = make_matched_scene(100, 0, 6);
  FundamentalRansac ransac({}, 100);
  std::vector<std::uint8_t> inlier(100);
  Matrix3d F;
  const RansacResult result = ransac.estimate(scene.s2, scene.s2, inlier, F);
  EXPECT_TRUE(result.ok());
  EXPECT_EQ(result.inliers, 100);
}

TEST(FundamentalRansac, TwoCallsGiveTheSameBits) {
  const MatchedScene scene = make_matched_scene(150, 0.3, 77);
  FundamentalRansac one({}, 150), larger({}, 400);
  std::vector<std::uint8_t> a(150), b(150);
  Matrix3d F, G;
  one.estimate(scene.r2, scene.s2, a, F);
  larger.estimate(scene.r2, scene.s2, b, G);
  EXPECT_EQ(F, G);
  EXPECT_EQ(a, b);
}

}  // namespace
}  // namespace onemap::mapping
