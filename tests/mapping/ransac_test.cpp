#include "mapping/local/ransac.hpp"

#include <gtest/gtest.h>

#include "support/poses.hpp"

namespace onemap::mapping {
namespace {

using test::SplitMix;

// Points of a scene 0.7 - 4 m in front of both cameras, r = T s, with pixel and depth noise and outliers.
struct Scene {
  Pose T_r_s;
  std::vector<Vector3d> r3, s3;
  std::vector<Eigen::Vector2d> r2, s2;
  std::vector<bool> good;
};

Scene make_scene(std::size_t n, double outliers, std::uint64_t seed, bool noise = true) {
  SplitMix random(seed);
  Scene scene;
  scene.T_r_s = test::random_pose(random, 0.15, 0.2);
  const auto measure = [&](const Vector3d& p) {
    const double pixel = noise ? 0.5 / 525 : 0, z = p.z();
    const double measured = z + (noise ? random.normal(0.0012 + 0.0019 * (z - 0.4) * (z - 0.4)) : 0);
    return Vector3d((p.x() / z + random.normal(pixel)) * measured, (p.y() / z + random.normal(pixel)) * measured,
                    measured);
  };
  const auto any = [&] {
    const double z = random.uniform(0.9, 4);
    return Vector3d(random.uniform(-0.5, 0.5) * z, random.uniform(-0.4, 0.4) * z, z);
  };
  for (std::size_t i = 0; i < n; ++i) {
    const Vector3d s = any();
    const bool good = random.uniform(0, 1) >= outliers;
    scene.good.push_back(good);
    scene.s3.push_back(measure(s));
    scene.r3.push_back(good ? measure(scene.T_r_s * s) : any());
    scene.r2.emplace_back(scene.r3.back().head<2>() / scene.r3.back().z());
    scene.s2.emplace_back(scene.s3.back().head<2>() / scene.s3.back().z());
  }
  return scene;
}

std::pair<int, int> right_and_wrong(const Scene& scene, const std::vector<std::uint8_t>& inlier) {
  int right = 0, wrong = 0;
  for (std::size_t i = 0; i < inlier.size(); ++i) (scene.good[i] ? right : wrong) += inlier[i];
  return {right, wrong};
}

TEST(FundamentalRansac, FindsTheTrueInliersAtEveryOutlierRate) {
  FundamentalRansac ransac({.max_iterations = 1000}, 300);
  for (const double outliers : {0.0, 0.1, 0.25, 0.4}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const Scene scene = make_scene(200, outliers, seed);
      std::vector<std::uint8_t> inlier(200);
      Matrix3d F;
      const RansacResult result = ransac.estimate(scene.r2, scene.s2, inlier, F);
      ASSERT_TRUE(result.ok()) << to_string(result.reason);
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
  const Scene scene = make_scene(60, 0, 9, false);
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
  Scene scene = make_scene(10, 0, 3);
  EXPECT_EQ(ransac.estimate(scene.r2, scene.s2, inlier, F).reason, RansacReason::too_few_matches);
  std::vector<Eigen::Vector2d> line;
  for (int i = 0; i < 50; ++i) line.emplace_back(0.01 * i, 0.02 * i - 0.3);
  EXPECT_EQ(ransac.estimate(line, line, inlier, F).reason, RansacReason::degenerate);
  scene = make_scene(100, 1.0, 4);
  EXPECT_EQ(FundamentalRansac({.min_inliers = 60}, 200).estimate(scene.r2, scene.s2, inlier, F).reason,
            RansacReason::too_few_inliers);
}

TEST(FundamentalRansac, ACameraThatDidNotMoveKeepsItsMatches) {
  const Scene scene = make_scene(100, 0, 6);
  FundamentalRansac ransac({}, 100);
  std::vector<std::uint8_t> inlier(100);
  Matrix3d F;
  const RansacResult result = ransac.estimate(scene.s2, scene.s2, inlier, F);
  EXPECT_TRUE(result.ok());
  EXPECT_EQ(result.inliers, 100);
}

TEST(RigidRansac, RecoversTheMotionAtEveryOutlierRate) {
  RigidRansac ransac({}, 300);
  for (const double outliers : {0.0, 0.25, 0.5, 0.7}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const Scene scene = make_scene(200, outliers, 100 + seed);
      std::vector<std::uint8_t> inlier(200);
      Pose T;
      const RansacResult result = ransac.estimate(scene.r3, scene.s3, inlier, T);
      ASSERT_TRUE(result.ok()) << to_string(result.reason);
      const auto [right, wrong] = right_and_wrong(scene, inlier);
      const auto good = std::count(scene.good.begin(), scene.good.end(), true);
      EXPECT_EQ(right + wrong, result.inliers);
      EXPECT_GT(right, 0.97 * static_cast<double>(good)) << "outliers " << outliers << " seed " << seed;
      EXPECT_LT(wrong, 5);
      EXPECT_LT((T.t - scene.T_r_s.t).norm(), 0.008);
      EXPECT_LT(rotation_angle(T.R.transpose() * scene.T_r_s.R), 0.005);
    }
  }
}

TEST(RigidRansac, ReasonsOfRefusal) {
  RigidRansac ransac({}, 200);
  std::vector<std::uint8_t> inlier(200, 1);
  Pose T;
  Scene scene = make_scene(5, 0, 3);
  EXPECT_EQ(ransac.estimate(scene.r3, scene.s3, inlier, T).reason, RansacReason::too_few_matches);
  std::vector<Vector3d> line;
  for (int i = 0; i < 50; ++i) line.emplace_back(0.01 * i, 0.02 * i - 0.3, 1 + 0.01 * i);
  EXPECT_EQ(ransac.estimate(line, line, inlier, T).reason, RansacReason::degenerate);
  scene = make_scene(100, 1.0, 4);
  EXPECT_EQ(ransac.estimate(scene.r3, scene.s3, inlier, T).reason, RansacReason::too_few_inliers);
  EXPECT_EQ(std::count(inlier.begin() + 100, inlier.end(), 1), 100) << "writes beyond the matches";
}

TEST(Ransac, TwoCallsGiveTheSameBits) {
  const Scene scene = make_scene(150, 0.3, 77);
  FundamentalRansac fundamental({}, 150), fundamental2({}, 400);
  RigidRansac rigid({}, 150);
  std::vector<std::uint8_t> a(150), b(150);
  Matrix3d F, G;
  fundamental.estimate(scene.r2, scene.s2, a, F);
  fundamental2.estimate(scene.r2, scene.s2, b, G);
  EXPECT_EQ(F, G);
  EXPECT_EQ(a, b);
  Pose S, T;
  rigid.estimate(scene.r3, scene.s3, a, S);
  rigid.estimate(scene.r3, scene.s3, b, T);
  EXPECT_EQ(S.R, T.R);
  EXPECT_EQ(S.t, T.t);
  EXPECT_EQ(a, b);
}

TEST(FitRigid, AgreesWithUmeyamaAndRefusesLines) {
  const Scene scene = make_scene(50, 0, 5);
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
