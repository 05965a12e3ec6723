#include "mapping/local/two_view.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "support/count_allocations.hpp"
#include "support/matched_scene.hpp"

namespace onemap::mapping {
namespace {

using test::make_matched_scene;
using test::MatchedScene;

FeatureCloud cloud(const std::vector<Vector3d>& points) {
  test::Random random(42);  // the same descriptors for both images
  FeatureCloud out;
  for (const Vector3d& p : points) {
    Descriptor d;
    for (auto& v : d.v) v = static_cast<std::int8_t>(random.uniform(-60, 60));
    out.set.keypoints.emplace_back();
    out.set.descriptors.push_back(d);
    out.ray.emplace_back(p.head<2>() / p.z());
    out.point.push_back(p);
  }
  return out;
}

// Feature i of both images is the same place, but for the outliers: a has scene.s3, b has scene.r3.
struct Views {
  explicit Views(double outliers, std::uint64_t seed = 5)
      : scene(make_matched_scene(120, outliers, seed)), a(cloud(scene.s3)), b(cloud(scene.r3)) {}
  MatchedScene scene;
  FeatureCloud a, b;
};

TEST(TwoView, FindsTheMotionAndWhichMatchesSayIt) {
  const Views views(0.3);
  TwoView two_view({}, 120);
  for (int call = 0; call < 2; ++call) {
    const TwoViewResult& r = two_view.relate(views.a, views.b);
    ASSERT_EQ(r.reason, TwoViewReason::ok) << static_cast<int>(r.reason);
    EXPECT_LT((r.T_b_a.t - views.scene.T_r_s.t).norm(), 0.01);
    EXPECT_LT(test::rotation_angle(r.T_b_a.R.transpose() * views.scene.T_r_s.R), 0.006);
    ASSERT_EQ(r.matches.size(), 120u);
    int wrong = 0;
    for (std::size_t i = 0; i < r.matches.size(); ++i) {
      EXPECT_EQ(r.matches[i].a, r.matches[i].b);
      wrong += r.kept[i] && !views.scene.good[r.matches[i].a];
    }
    EXPECT_LT(wrong, 3);
    EXPECT_EQ(std::count(r.kept.begin(), r.kept.end(), 1), r.inliers);
    EXPECT_GT(r.inliers, 60);
  }
}

// The matches name their images whichever of them looks; they come in the order of the one that does.
TEST(TwoView, EitherImageMayLookUpItsFeaturesInTheOther) {
  Views views(0);
  std::reverse(views.b.set.descriptors.begin(), views.b.set.descriptors.end());
  std::reverse(views.b.ray.begin(), views.b.ray.end());
  std::reverse(views.b.point.begin(), views.b.point.end());
  for (const LookUp look_up : {LookUp::a_in_b, LookUp::b_in_a}) {
    TwoViewConfig config;
    config.look_up = look_up;
    TwoView two_view(config, 120);
    const TwoViewResult& r = two_view.relate(views.a, views.b);
    ASSERT_EQ(r.reason, TwoViewReason::ok);
    EXPECT_LT((r.T_b_a.t - views.scene.T_r_s.t).norm(), 0.01);
    for (std::size_t i = 0; i < r.matches.size(); ++i) {
      EXPECT_EQ(r.matches[i].a + r.matches[i].b, 119);
      EXPECT_EQ(look_up == LookUp::a_in_b ? r.matches[i].a : r.matches[i].b, i);
    }
  }
}

TEST(TwoView, SaysWhichStepFailed) {
  TwoView two_view({}, 120);
  Views strangers(0);
  for (Descriptor& d : strangers.b.set.descriptors) d.v.fill(0);
  EXPECT_EQ(two_view.relate(strangers.a, strangers.b).reason, TwoViewReason::too_few_matches);

  TwoViewConfig demanding;
  demanding.fundamental.min_inliers = 90;
  const Views all_wrong(1.0);
  EXPECT_EQ(TwoView(demanding, 120).relate(all_wrong.a, all_wrong.b).reason, TwoViewReason::fundamental_failed);

  Views flat(0);
  for (std::size_t i = 11; i < flat.a.size(); ++i) (i % 2 == 0 ? flat.a : flat.b).point[i] = Vector3d::Zero();
  const TwoViewResult& r = two_view.relate(flat.a, flat.b);
  EXPECT_EQ(r.reason, TwoViewReason::depth_incoherent) << "eleven matches have a depth on both sides";
  EXPECT_EQ(std::count(r.kept.begin(), r.kept.end(), 1), 0);

  Views deep(0);
  test::Random random(3);
  for (Vector3d& p : deep.a.point) p *= random.uniform(0.3, 3);
  EXPECT_EQ(two_view.relate(deep.a, deep.b).reason, TwoViewReason::ransac_failed);
}

TEST(TwoView, CallsTheHookAtEachStepAndAllocatesNothing) {
  const Views views(0.2);
  std::vector<Step> steps;
  steps.reserve(16);
  const StepHook hook{[](void* s, Step step) { static_cast<std::vector<Step>*>(s)->push_back(step); }, &steps};
  TwoView two_view({}, 120);
  const std::uint64_t before = test::allocations();
  two_view.relate(views.a, views.b, hook);
  EXPECT_EQ(test::allocations(), before);
  EXPECT_EQ(steps, (std::vector<Step>{Step::match, Step::fundamental, Step::ransac}));
}

}  // namespace
}  // namespace onemap::mapping
