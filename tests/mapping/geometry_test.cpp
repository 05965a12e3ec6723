#include "mapping/geometry.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/poses.hpp"

namespace onemap::mapping {
namespace {

using test::Random;
using test::random_pose;
using test::rotation;

TEST(Geometry, PoseComposesAndInverts) {
  Random random(3);
  for (int i = 0; i < 100; ++i) {
    const Pose a = random_pose(random, 3.1, 2), b = random_pose(random, 3.1, 2);
    const Vector3d p(0.3, -1, 2);
    EXPECT_LT(((a * b) * p - a * (b * p)).norm(), 1e-12);
    EXPECT_LT((a.inverse() * (a * p) - p).norm(), 1e-12);
  }
}

TEST(Geometry, QuaternionAgreesWithEigenInEveryBranch) {
  Random random(5);
  for (int i = 0; i < 1000; ++i) {
    const Matrix3d R = random_pose(random, 3.14, 1).R;
    const auto q = to_quaternion_wxyz(R);
    const Eigen::Quaterniond judge(R);
    const double sign = judge.w() < 0 ? -1 : 1;
    EXPECT_GE(q[0], 0);
    EXPECT_NEAR(q[0], sign * judge.w(), 1e-9);
    EXPECT_NEAR(q[1], sign * judge.x(), 1e-9);
    EXPECT_NEAR(q[2], sign * judge.y(), 1e-9);
    EXPECT_NEAR(q[3], sign * judge.z(), 1e-9);
    EXPECT_LT((from_quaternion_wxyz(q) - R).norm(), 1e-9);
  }
}

TEST(Geometry, OrthonormalRemovesScaleAndSkew) {
  const Matrix3d R = rotation({1, 2, -1}, 0.7);
  Matrix3d drifted = R * 1.001;
  drifted(0, 1) += 1e-3;
  const Matrix3d out = orthonormal(drifted);
  EXPECT_LT((out * out.transpose() - Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_NEAR(out.determinant(), 1, 1e-12);
  EXPECT_LT((out - R).norm(), 2e-3);
}

TEST(Geometry, SmallMotionIsTheCayleyRotation) {
  for (const double angle : {1e-8, 1e-3, 0.1, 1.0, 2.5}) {
    const Vector3d axis = Vector3d(1, -2, 0.5).normalized();
    Vector6d wv;
    wv << 2 * std::tan(angle / 2) * axis, 0.1, 0.2, 0.3;
    const Pose motion = small_motion(wv);
    EXPECT_LT((motion.R - rotation(axis, angle)).norm(), 1e-12) << angle;
    EXPECT_EQ(motion.t, Vector3d(0.1, 0.2, 0.3));
    EXPECT_NEAR(test::rotation_angle(motion.R), angle, 1e-9);
  }
}

TEST(Geometry, RotationCosineIsTheCosineOfTheAngle) {
  Random random(7);
  for (int i = 0; i < 200; ++i) {
    const Matrix3d R = random_pose(random, 3.1, 1).R;
    EXPECT_NEAR(rotation_cosine(R), std::cos(test::rotation_angle(R)), 1e-12);
  }
}

TEST(Geometry, QuantizedPoseIsAFixedPointWithinHalfAUnit) {
  Random random(11);
  for (int i = 0; i < 200; ++i) {
    const Pose pose = random_pose(random, 3.1, 5);
    const QuantizedPose q = quantize(pose);
    const Pose back = from_quantized(q);
    EXPECT_LT((back.t - pose.t).cwiseAbs().maxCoeff(), 0.51e-5);
    EXPECT_LT(test::rotation_angle(back.R.transpose() * pose.R), 1e-7);
    EXPECT_EQ(from_quantized(quantize(back)).t, back.t);
  }
}

}  // namespace
}  // namespace onemap::mapping
