#include "mapping/local/orb.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "mapping/local/match.hpp"
#include "texture.hpp"

namespace onemap::mapping {
namespace {

FeatureSet detect(const test::GreyImage& image) {
  FeatureSet out;
  out.reserve(500);
  Orb({}, image.width, image.height).detect(image.view(), out);
  return out;
}

TEST(Orb, KeepsTheContractOfAFeatureSet) {
  const FeatureSet found = detect(test::textured(400, 300, 7));
  EXPECT_EQ(found.kind, DescriptorKind::orb);
  EXPECT_GT(found.size(), 300U);
  EXPECT_LE(found.size(), 500U);
  ASSERT_EQ(found.keypoints.size(), found.descriptors.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Keypoint& k = found.keypoints[i];
    EXPECT_GE(found.keypoints[i > 0 ? i - 1 : 0].response, k.response);
    EXPECT_NEAR(k.cos_angle * k.cos_angle + k.sin_angle * k.sin_angle, 1, 1e-5);
    for (std::size_t c = 32; c < 64; ++c) EXPECT_EQ(found.descriptors[i].v[c], 0);
  }
}

TEST(Orb, MatchesATurnedView) {
  const test::Similarity warp{200, 150, 25 * std::numbers::pi / 180, 1};
  const FeatureSet a = detect(test::textured(400, 300, 7)), b = detect(test::textured(400, 300, 7, &warp));
  Matcher matcher({}, 500);
  const auto matches = matcher.match(a, b);
  int right = 0;
  for (const Match& m : matches) {
    double u = 0, v = 0;
    warp.to_image(a.keypoints[m.a].x_px, a.keypoints[m.a].y_px, u, v);
    right += std::hypot(u - b.keypoints[m.b].x_px, v - b.keypoints[m.b].y_px) < 4 ? 1 : 0;
  }
  EXPECT_GT(matches.size(), 60U);
  EXPECT_GT(right, 0.8 * static_cast<double>(matches.size()));
}

TEST(Orb, AFlatImageHasNoFeatures) {
  EXPECT_EQ(detect(test::paint(200, 150, [](double, double) { return 90; })).size(), 0U);
}

}  // namespace
}  // namespace onemap::mapping
