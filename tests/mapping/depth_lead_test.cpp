#include "local/tracking/depth_lead.hpp"

#include <gtest/gtest.h>

#include "support/poses.hpp"
#include "support/stream.hpp"

namespace onemap::mapping {
namespace {

// A frame's cloud, sampled as the tracker sees it and organised as a keyframe keeps it.
struct Sight {
  explicit Sight(const hal::FrameView& frame) {
    FrontEnd front_end({}, *frame.intrinsics);
    Observed seen = front_end.make_observed();
    front_end.observe(frame, {}, seen);
    cloud = seen.cloud;
    organize(frame.depth, *frame.intrinsics, kGridWidth, kGridHeight, organised);
  }
  std::vector<Vector3f> cloud;
  OrganizedCloud organised;
};

// What a camera sees before a wall 2 m away and, where a side is given, another one at a right angle to its right.
struct Walls {
  explicit Walls(bool corner) : rgb(640u * 480 * 3, 128), depth(640u * 480) {
    for (int v = 0; v < 480; ++v)
      for (int u = 0; u < 640; ++u) {
        const double x = (u - k.cx) / k.fx, z = corner && x > 0.35 ? 0.7 / x : 2.0;
        depth[static_cast<std::size_t>(v) * 640 + static_cast<std::size_t>(u)] =
            static_cast<std::uint16_t>(z * k.depth_scale + 0.5);
      }
  }
  hal::FrameView view() const { return {{}, {}, 0, &k, rgb, depth}; }
  hal::Intrinsics k;
  std::vector<std::uint8_t> rgb;
  std::vector<std::uint16_t> depth;
};

Vector6d direction(int i) {
  Vector6d d = Vector6d::Zero();
  d[i] = 1;
  return d;
}

// A wall says how far away it is and how it is turned. It does not say where along it the camera is, nor its roll.
TEST(DepthLead, AWallSaysThreeDirections) {
  const Walls walls(false);
  const Sight sight(walls.view());
  const IcpResult self = Icp({}).align(sight.organised, sight.cloud, Pose{});
  const auto information = prior_of_depth(self, Pose{}, 2).information;
  const auto says = [&](int i) { return direction(i).dot(information * direction(i)); };
  for (const int seen : {0, 1, 5}) EXPECT_GT(says(seen), 1e4) << seen;
  for (const int unseen : {2, 3, 4}) EXPECT_LT(says(unseen), 1) << unseen;
  EXPECT_FALSE(sees_all(information, 2));
  EXPECT_FALSE(depth_sees_all(sight.organised, sight.cloud, Icp({})));
}

TEST(DepthLead, AFurnishedRoomSaysAll) {
  test::Stream stream("simulated:living-room?frames=1");
  const auto frame = stream.next();
  const Sight sight(frame->view());
  EXPECT_TRUE(depth_sees_all(sight.organised, sight.cloud, Icp({})));
}

// Two walls leave the height free: what is expected stays there, to the last micrometre, and depth rules the rest.
TEST(DepthLead, WhatNothingSeesIsTakenFromTheMotion) {
  const Walls walls(true);
  FrontEnd front_end({}, walls.k);
  Observed seen = front_end.make_observed();
  front_end.observe(walls.view(), {}, seen);
  KeyframeMap map({12, 500, 0.1, 8}, walls.k);
  LandmarkFit fit(walls.k, 500);
  map.add(walls.view(), Pose{}, seen.features);
  Motion::Expected expected;
  expected.T_camera_robot.t = {0.02, 0.05, -0.02};
  Vector6d sure;
  sure << Vector3d::Constant(1e4), Vector3d::Constant(1e4);
  expected.information = sure.asDiagonal();
  const auto led = lead_by_depth(seen, map, expected, false, Icp({}), fit, {});
  ASSERT_TRUE(led);
  EXPECT_FALSE(led->all_seen);
  EXPECT_EQ(led->inliers, 0);
  EXPECT_NEAR(led->T_camera_robot.t.x(), 0, 0.004);
  EXPECT_NEAR(led->T_camera_robot.t.y(), 0.05, 1e-3);
  EXPECT_NEAR(led->T_camera_robot.t.z(), 0, 0.004);
}

TEST(DepthLead, AJumpFromWhereTheCameraIsExpectedIsRefused) {
  test::Stream stream("simulated:blank-walls?frames=1&seed=1&robot=3");
  const auto frame = stream.next();
  FrontEnd front_end({}, stream.intrinsics());
  Observed seen = front_end.make_observed();
  front_end.observe(frame->view(), {}, seen);
  KeyframeMap map({12, 500, 0.1, 8}, stream.intrinsics());
  LandmarkFit fit(stream.intrinsics(), 500);
  map.add(frame->view(), Pose{}, seen.features);
  Motion::Expected expected;
  expected.information = Eigen::Matrix<double, 6, 6>::Identity();
  EXPECT_TRUE(lead_by_depth(seen, map, expected, true, Icp({}), fit, {}));
  expected.T_camera_robot.t = {0, 0, 0.15};
  EXPECT_FALSE(lead_by_depth(seen, map, expected, true, Icp({}), fit, {}));
}

TEST(DepthLead, ACloudOfAnotherPlaceIsNotOnTheSurface) {
  test::Stream here("simulated:living-room?frames=1"), there("simulated:storage?frames=1");
  const Sight a(here.next()->view()), b(there.next()->view());
  EXPECT_GT(share_on_surface(a.organised, a.cloud, Pose{}), 0.95);
  EXPECT_LT(share_on_surface(a.organised, b.cloud, Pose{}), 0.4);
  EXPECT_EQ(share_on_surface(a.organised, {}, Pose{}), 0);
  const Pose aside{test::rotation({0, 1, 0}, 0.9), {}};
  EXPECT_EQ(share_on_surface(a.organised, a.cloud, aside), 0) << "most of it is out of view";
}

}  // namespace
}  // namespace onemap::mapping
