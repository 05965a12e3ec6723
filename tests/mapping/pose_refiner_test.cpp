#include "local/tracking/pose_refiner.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "support/poses.hpp"

namespace onemap::mapping {
namespace {

constexpr double kFocal_px = 525;

Pose motion(double wx, double wy, double wz, double x, double y, double z) {
  Vector6d wv;
  wv << wx, wy, wz, x, y, z;
  return small_motion(wv);
}

double uniform(std::uint64_t& state, double low, double high) {
  state = state * 6364136223846793005ull + 1442695040888963407ull;
  return low + (high - low) * static_cast<double>(state >> 11) / static_cast<double>(1ull << 53);
}

// Points 1 to 4 m in front of a camera at T_camera_robot, seen exactly.
std::vector<PoseObservation> scene(const Pose& T_camera_robot, int count, bool with_depth) {
  std::uint64_t state = 7;
  std::vector<PoseObservation> out;
  for (int i = 0; i < count; ++i) {
    const double z = uniform(state, 1, 4);
    const Vector3d p(uniform(state, -0.5, 0.5) * z, uniform(state, -0.4, 0.4) * z, z);
    PoseObservation o;
    o.p_robot = T_camera_robot.inverse() * p;
    o.o.ray = {p.x() / z, p.y() / z};
    o.o.inverse_depth = with_depth ? 1 / z : 0;
    out.push_back(o);
  }
  return out;
}

double distance(const Pose& a, const Pose& b) {
  const Pose d = a.inverse() * b;
  return d.t.norm() + test::rotation_angle(d.R);
}

TEST(RefinePose, FindsTheExactPoseFromExactObservations) {
  const Pose truth = motion(0.3, -0.2, 0.1, 0.5, -0.1, 0.2);
  for (const bool with_depth : {true, false}) {
    auto observations = scene(truth, 80, with_depth);
    Pose T = motion(0.02, 0.01, -0.02, 0.03, 0.02, -0.03) * truth;
    const RefineResult r = refine_pose(observations, kFocal_px, nullptr, T);
    EXPECT_EQ(r.inliers, 80);
    EXPECT_LT(distance(truth, T), 1e-6);
  }
}

TEST(RefinePose, MarksOutliersAndIsNotPulledByThem) {
  const Pose truth = motion(0.1, 0.2, 0, 0.2, 0, 0.1);
  auto observations = scene(truth, 100, true);
  for (std::size_t i = 0; i < 30; ++i) observations[i].o.ray += Eigen::Vector2d(0.1, i % 2 == 0 ? 0.05 : -0.05);
  Pose T = motion(0.01, 0, 0.01, 0.02, 0, 0) * truth;
  const RefineResult r = refine_pose(observations, kFocal_px, nullptr, T);
  EXPECT_EQ(r.inliers, 70);
  for (std::size_t i = 0; i < observations.size(); ++i) EXPECT_EQ(observations[i].inlier, i >= 30) << i;
  EXPECT_LT(distance(truth, T), 1e-4);
}

TEST(RefinePose, AStrongPriorDecidesAndAWeakOneDoesNot) {
  const Pose truth = motion(0, 0.1, 0, 0.1, 0, 0), elsewhere = motion(0, 0, 0, 0.004, 0, 0) * truth;
  for (const double weight : {1e12, 1e-6}) {
    auto observations = scene(truth, 60, true);
    PosePrior prior;
    prior.T_camera_robot = elsewhere;
    prior.information = Eigen::Matrix<double, 6, 6>::Identity() * weight;
    Pose T = truth;
    refine_pose(observations, kFocal_px, &prior, T);
    EXPECT_LT(distance(weight > 1 ? elsewhere : truth, T), 1e-4) << weight;
  }
}

// The adjoint, against finite motions: the same disturbance costs the same seen from either side.
TEST(InformationOfInverse, CostsTheSameFromBothSides) {
  const Pose T = motion(0.4, -0.3, 0.2, 1, -2, 0.5);
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Identity();
  information(0, 0) = 5;
  information(4, 4) = 9;
  information(1, 3) = information(3, 1) = 0.5;
  Vector6d e;
  e << 1e-6, -2e-6, 1e-6, 3e-6, 1e-6, -1e-6;
  const Pose disturbed = (small_motion(e) * T.inverse()).inverse();  // T' with the inverse moved by e
  const Pose d_pose = disturbed * T.inverse();
  const auto q = to_quaternion_wxyz(d_pose.R);
  Vector6d d;
  d << 2 * q[1] / q[0], 2 * q[2] / q[0], 2 * q[3] / q[0], d_pose.t;
  const double direct = d.dot(information * d), moved = e.dot(information_of_inverse(information, T) * e);
  EXPECT_NEAR(moved / direct, 1, 1e-4);
}

}  // namespace
}  // namespace onemap::mapping
