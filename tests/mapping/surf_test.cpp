#include "mapping/local/surf.hpp"

#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string>

#include "hal/backends/replay.hpp"
#include "hal/frame_pool.hpp"
#include "mapping/local/match.hpp"
#include "texture.hpp"

namespace onemap::mapping {
namespace {

using test::GreyImage;
using test::Similarity;

FeatureSet detect(const GreyImage& image, const SurfConfig& config = {}) {
  FeatureSet out;
  out.reserve(static_cast<std::size_t>(config.max_features));
  Surf(config, image.width, image.height).detect(image.view(), out);
  return out;
}

GreyImage blob(double cx, double cy, double sigma, double background, double peak) {
  return test::paint(160, 120, [=](double x, double y) {
    const double r2 = (x - cx) * (x - cx) + (y - cy) * (y - cy);
    return background + (peak - background) * std::exp(-r2 / (2 * sigma * sigma));
  });
}

bool same(const FeatureSet& a, const FeatureSet& b) {
  return a.keypoints == b.keypoints && a.descriptors == b.descriptors;
}

// The determinant of the paper's box filters by adding up pixels one by one.
double brute_force_determinant(const GreyImage& image, int x, int y, int filter) {
  const int lobe = filter / 3;
  const auto weighted = [&](auto weight) {
    double sum = 0;
    for (int dy = -filter / 2; dy <= filter / 2; ++dy)
      for (int dx = -filter / 2; dx <= filter / 2; ++dx)
        sum += weight(dx, dy) * image.pixels[static_cast<std::size_t>((y + dy) * image.width + x + dx)];
    return sum / (filter * filter);
  };
  const auto three_lobes = [&](int along, int across) {
    if (std::abs(across) >= lobe) return 0;
    return std::abs(along) <= lobe / 2 ? -2 : 1;
  };
  const double dxx = weighted([&](int dx, int dy) { return three_lobes(dx, dy); });
  const double dyy = weighted([&](int dx, int dy) { return three_lobes(dy, dx); });
  const double dxy = weighted([&](int dx, int dy) {
    if (dx == 0 || dy == 0 || std::abs(dx) > lobe || std::abs(dy) > lobe) return 0;
    return (dx > 0) == (dy > 0) ? -1 : 1;
  });
  return dxx * dyy - 0.81 * dxy * dxy;
}

TEST(Surf, FindsABlobWhereItIs) {
  for (const double sigma : {2.5, 4.0, 6.0}) {
    const FeatureSet found = detect(blob(80.3, 60.4, sigma, 40, 200));
    ASSERT_GE(found.size(), 1u) << sigma;
    EXPECT_NEAR(found.keypoints[0].x_px, 80.3, 0.25) << sigma;
    EXPECT_NEAR(found.keypoints[0].y_px, 60.4, 0.25) << sigma;
    EXPECT_EQ(found.keypoints[0].laplacian, -1);
  }
  EXPECT_EQ(detect(blob(80, 60, 4, 200, 40)).keypoints.at(0).laplacian, 1);
}

TEST(Surf, SizeFollowsTheBlob) {
  const float small = detect(blob(80, 60, 3, 40, 200)).keypoints.at(0).size_px;
  const float large = detect(blob(80, 60, 6, 40, 200)).keypoints.at(0).size_px;
  EXPECT_NEAR(large / small, 2.0, 0.25);
}

TEST(Surf, ResponseIsTheDeterminantOfThePaper) {
  const GreyImage image = blob(80.3, 60.4, 2.5, 40, 200);
  const FeatureSet found = detect(image);
  ASSERT_GE(found.size(), 1u);
  double largest = 0;
  for (const int filter : {15, 21, 27, 39})
    for (int y = 58; y <= 62; ++y)
      for (int x = 78; x <= 82; ++x) largest = std::max(largest, brute_force_determinant(image, x, y, filter));
  EXPECT_NEAR(found.keypoints[0].response, largest, 1e-4 * largest);
}

TEST(Surf, FlatAndTinyImagesHaveNoFeatures) {
  EXPECT_EQ(detect(test::paint(200, 150, [](double, double) { return 130; })).size(), 0u);
  for (const int side : {1, 8, 9, 16, 28})
    EXPECT_EQ(detect(test::paint(side, side, [](double, double) { return 130; })).size(), 0u) << side;
}

// Features of one view are found again in a turned and scaled view of the same plane, and described alike.
void expect_matches(double degrees, double scale, double least_share, const SurfConfig& config = {}) {
  const Similarity warp{200, 150, degrees * std::numbers::pi / 180, scale};
  const FeatureSet a = detect(test::textured(400, 300, 7), config),
                   b = detect(test::textured(400, 300, 7, &warp), config);
  ASSERT_GT(a.size(), 200u);
  Matcher matcher({}, 500);
  const auto matches = matcher.match(a, b);
  int right = 0;
  for (const Match& m : matches) {
    double u = 0, v = 0;
    warp.to_image(a.keypoints[m.a].x_px, a.keypoints[m.a].y_px, u, v);
    right += std::hypot(u - b.keypoints[m.b].x_px, v - b.keypoints[m.b].y_px) < 2.5 * scale ? 1 : 0;
  }
  EXPECT_GE(matches.size(), 60u) << degrees << " degrees, scale " << scale;
  EXPECT_GE(right, least_share * static_cast<double>(matches.size())) << degrees << " degrees, scale " << scale;
}

TEST(Surf, MatchesTurnedViews) {
  for (const double degrees : {5.0, 30.0, 45.0, 90.0, 137.0, 180.0, -70.0}) expect_matches(degrees, 1, 0.9);
}

TEST(Surf, MatchesScaledViews) {
  for (const double scale : {0.8, 1.25, 1.5}) expect_matches(20, scale, 0.8);
}

TEST(Surf, UprightMatchesViewsThatAreHardlyTurned) {
  expect_matches(0, 1.1, 0.9, {.upright = true});
  expect_matches(8, 1, 0.9, {.upright = true});
}

TEST(Surf, DirectionTurnsWithTheImage) {
  const Similarity warp{200, 150, std::numbers::pi / 2, 1};
  const FeatureSet a = detect(test::textured(400, 300, 3)), b = detect(test::textured(400, 300, 3, &warp));
  int compared = 0, turned = 0;
  for (const Keypoint& p : a.keypoints)
    for (const Keypoint& q : b.keypoints) {
      double u = 0, v = 0;
      warp.to_image(p.x_px, p.y_px, u, v);
      if (std::hypot(u - q.x_px, v - q.y_px) > 0.3 || std::abs(p.size_px - q.size_px) > 1) continue;
      ++compared;
      turned += -p.sin_angle * q.cos_angle + p.cos_angle * q.sin_angle > 0.95F ? 1 : 0;
    }
  EXPECT_GT(compared, 100);
  EXPECT_GT(turned, 0.85 * compared);
}

TEST(Surf, SimdAndPlainGiveTheSameBits) {
  for (const auto& [width, height] : {std::pair{640, 480}, {161, 123}, {90, 200}, {401, 99}})
    for (const bool upright : {false, true}) {
      const GreyImage image = test::textured(width, height, static_cast<std::uint32_t>(width));
      SurfConfig config{.hessian_threshold = 1, .upright = upright};
      const FeatureSet fast = detect(image, config);
      config.simd = false;
      EXPECT_TRUE(same(fast, detect(image, config))) << width << "x" << height;
      EXPECT_GT(fast.size(), 20u);
    }
}

TEST(Surf, ReadsRowsByTheirStride) {
  const GreyImage image = test::textured(200, 150, 5);
  std::vector<std::uint8_t> wide(static_cast<std::size_t>(256 * 150), 77);
  for (std::size_t y = 0; y < 150; ++y) std::memcpy(&wide[256 * y], &image.pixels[200 * y], 200);
  FeatureSet out;
  out.reserve(500);
  Surf({}, 200, 150).detect({wide.data(), 200, 150, 256}, out);
  EXPECT_TRUE(same(out, detect(image)));
}

TEST(Surf, AnImageLeavesNothingForTheNext) {
  const GreyImage first = test::textured(320, 240, 1), second = test::textured(320, 240, 2);
  Surf surf({}, 320, 240);
  FeatureSet out;
  out.reserve(500);
  surf.detect(first.view(), out);
  surf.detect(second.view(), out);
  EXPECT_TRUE(same(out, detect(second)));
}

TEST(Surf, KeepsTheStrongestAndSpreadsThem) {
  // Strong texture left, weak texture right: without spreading the left half would take all.
  const GreyImage image = test::paint(
      640, 480, [](double x, double y) { return 128 + (x < 320 ? 200 : 80) * (test::texture(x, y, 9) - 0.5); });
  const FeatureSet found = detect(image, {.max_features = 200, .hessian_threshold = 1});
  ASSERT_EQ(found.size(), 200u);
  int right = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    right += found.keypoints[i].x_px > 330 ? 1 : 0;
    EXPECT_GE(found.keypoints[i > 0 ? i - 1 : 0].response, found.keypoints[i].response);
  }
  EXPECT_GT(right, 20);
  EXPECT_GT(found.keypoints[0].response, 0);
}

TEST(Surf, DetectTakesNoMemory) {
  const GreyImage image = test::textured(640, 480, 11);
  Surf surf({.hessian_threshold = 0.1F}, 640, 480);
  FeatureSet out;
  out.reserve(500);
  const void* keypoints = out.keypoints.data();
  const auto before = mallinfo2();
  surf.detect(image.view(), out);
  const auto after = mallinfo2();
  EXPECT_EQ(before.uordblks, after.uordblks);
  EXPECT_EQ(keypoints, out.keypoints.data());
  EXPECT_EQ(out.size(), 500u);
  EXPECT_LT(surf.bytes(), 16u << 20);
}

// Two frames of a hand-held recording a third of a second apart: whole images move by about one displacement, within
// the parallax of a desk, where a wrong match lies anywhere.
TEST(Surf, MatchesFramesOfARecording) {
  const std::string address = "replay:" ONEMAP_SHARED_DIR "/data/fr1_xyz:100:111";
  const auto parsed = hal::parse_camera_address(address);
  ASSERT_TRUE(parsed.ok());
  auto camera = hal::open_replay(parsed.value());
  if (!camera.ok()) GTEST_SKIP() << "no recording fr1_xyz in " ONEMAP_SHARED_DIR "/data";
  hal::FramePool pool(camera.value()->intrinsics(), 1);
  std::vector<FeatureSet> found;
  for (int i = 0; i < 11; ++i) {
    hal::Frame frame = pool.acquire();
    ASSERT_EQ(camera.value()->grab(frame, std::chrono::seconds(1)), hal::Grab::frame);
    GreyImage grey{640, 480, std::vector<std::uint8_t>(640 * 480)};
    to_gray(frame.rgb(), grey.pixels);
    if (i % 10 == 0) found.push_back(detect(grey));
  }
  EXPECT_EQ(found[0].size(), 500u);
  Matcher matcher({}, 500);
  const auto matches = matcher.match(found[0], found[1]);
  std::vector<float> dx, dy;
  for (const Match& m : matches) {
    dx.push_back(found[1].keypoints[m.b].x_px - found[0].keypoints[m.a].x_px);
    dy.push_back(found[1].keypoints[m.b].y_px - found[0].keypoints[m.a].y_px);
  }
  ASSERT_GE(matches.size(), 80u);
  const auto median = [](std::vector<float> v) {
    std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2), v.end());
    return v[v.size() / 2];
  };
  const float mx = median(dx), my = median(dy);
  int together = 0;
  for (std::size_t i = 0; i < dx.size(); ++i) together += std::hypot(dx[i] - mx, dy[i] - my) < 30 ? 1 : 0;
  EXPECT_GE(together, 0.75 * static_cast<double>(matches.size()));
}

}  // namespace
}  // namespace onemap::mapping
