#include "local/tracking/front_end.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "support/count_allocations.hpp"
#include "support/stream.hpp"

namespace onemap::mapping {
namespace {

const char* const kRoom = "simulated:living-room?frames=2&width=320&height=240";

TEST(FrontEnd, GivesFeaturesTheirPointsAndTheFrameItsCloud) {
  test::Stream stream(kRoom);
  const auto frame = stream.next();
  FrontEnd front_end({}, stream.intrinsics());
  Observed seen = front_end.make_observed();
  front_end.observe(frame->view(), {}, seen);
  const FeatureFrame& f = seen.features;
  ASSERT_GT(f.size(), 60u);
  ASSERT_EQ(f.point.size(), f.size());
  int with_depth = 0;
  for (std::size_t i = 0; i < f.size(); ++i) {
    EXPECT_EQ(f.landmark[i], -1);
    if (!f.has_depth(i)) continue;
    ++with_depth;
    const Keypoint& k = f.set.keypoints[i];
    const auto pixel =
        static_cast<std::size_t>(std::lround(k.y_px)) * 320 + static_cast<std::size_t>(std::lround(k.x_px));
    const double z = frame->view().depth[pixel] / stream.intrinsics().depth_scale;
    if (z > 0) {
      EXPECT_NEAR(f.point[i].z(), z, 0.05 * z) << "the reading under the feature";
    }
    EXPECT_LT((f.point[i].head<2>() / f.point[i].z() - f.ray[i]).norm(), 1e-12) << "eq. (5)";
  }
  EXPECT_GT(with_depth, 40);
  EXPECT_GT(seen.cloud.size(), 300u);
  EXPECT_LT(seen.cloud.size(), 320u * 240 / 16) << "downsampled";
}

TEST(FrontEnd, LeavesFarPointsOutOfTheCloud) {
  test::Stream stream(kRoom);
  auto frame = stream.next();
  FrontEndConfig config;
  config.cloud_far_m = 5;
  FrontEnd front_end(config, stream.intrinsics());
  Observed seen = front_end.make_observed();
  for (const double z_m : {4.9, 5.1}) {
    std::fill(frame->depth().begin(), frame->depth().end(),
              static_cast<std::uint16_t>(z_m * stream.intrinsics().depth_scale));
    front_end.observe(frame->view(), {}, seen);
    EXPECT_EQ(seen.cloud.empty(), z_m > 5);
    EXPECT_TRUE(seen.features.has_depth(0));
  }
}

TEST(FrontEnd, KeepsNothingOfTheFrameBeforeAndAllocatesNothing) {
  test::Stream stream(kRoom);
  FrontEnd front_end({}, stream.intrinsics()), fresh({}, stream.intrinsics());
  Observed seen = front_end.make_observed(), alone = fresh.make_observed();
  front_end.observe(stream.next()->view(), {}, seen);
  const auto second = stream.next();
  std::vector<Step> steps;
  steps.reserve(8);
  const StepHook hook{[](void* s, Step step) { static_cast<std::vector<Step>*>(s)->push_back(step); }, &steps};
  const std::uint64_t before = test::allocations();
  front_end.observe(second->view(), hook, seen);
  EXPECT_EQ(test::allocations(), before);
  EXPECT_EQ(steps, (std::vector<Step>{Step::gray, Step::features, Step::cloud}));
  fresh.observe(second->view(), {}, alone);
  EXPECT_EQ(seen.features.set.descriptors, alone.features.set.descriptors);
  EXPECT_EQ(seen.features.point, alone.features.point);
  EXPECT_EQ(seen.cloud, alone.cloud);
}

TEST(FrontEnd, OrbIsAnAlternative) {
  test::Stream stream(kRoom);
  FrontEndConfig config;
  config.features = DescriptorKind::orb;
  FrontEnd front_end(config, stream.intrinsics());
  Observed seen = front_end.make_observed();
  front_end.observe(stream.next()->view(), {}, seen);
  EXPECT_EQ(seen.features.set.kind, DescriptorKind::orb);
  EXPECT_GT(seen.features.size(), 60u);
}

}  // namespace
}  // namespace onemap::mapping
