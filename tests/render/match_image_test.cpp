#include "render/match_image.hpp"

#include <gtest/gtest.h>

namespace onemap::render {
namespace {

using mapping::FeatureSet;

FeatureSet features_at(std::initializer_list<std::pair<float, float>> places) {
  FeatureSet set;
  for (const auto& [x, y] : places) {
    mapping::Keypoint k;
    k.x_px = x;
    k.y_px = y;
    set.keypoints.push_back(k);
    set.descriptors.emplace_back();
  }
  return set;
}

std::vector<std::uint8_t> flat(int width, int height, std::uint8_t value) {
  return std::vector<std::uint8_t>(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height), value);
}

bool greenish(std::array<std::uint8_t, 3> c) { return c[1] > 150 && c[0] < 100; }
bool reddish(std::array<std::uint8_t, 3> c) { return c[0] > 150 && c[1] < 100; }

// Images of different height, so that the corner below the smaller one must stay black.
TEST(MatchImage, kept_matches_are_green_rejected_red_and_the_photographs_stay) {
  const auto left_rgb = flat(100, 80, 50), right_rgb = flat(90, 60, 70);
  const FeatureSet left = features_at({{20, 20}, {20, 50}, {50, 70}}), right = features_at({{40, 20}, {30, 50}});
  const std::vector<mapping::Match> matches{{0, 0, 5}, {1, 1, 9}};
  const Image image =
      draw_matches({left_rgb, 100, 80, left}, {right_rgb, 90, 60, right}, matches, std::vector<std::uint8_t>{1, 0});
  ASSERT_EQ(image.width, 190);
  ASSERT_EQ(image.height, 80);
  EXPECT_EQ(image.at(5, 5), (std::array<std::uint8_t, 3>{50, 50, 50}));
  EXPECT_EQ(image.at(185, 5), (std::array<std::uint8_t, 3>{70, 70, 70}));
  EXPECT_EQ(image.at(150, 75), (std::array<std::uint8_t, 3>{0, 0, 0}));
  for (int x = 30; x < 130; ++x) EXPECT_TRUE(greenish(image.at(x, 20))) << x;  // from (20, 20) to (140, 20)
  for (int x = 30; x < 120; ++x) EXPECT_TRUE(reddish(image.at(x, 50))) << x;   // from (20, 50) to (130, 50)
  EXPECT_FALSE(greenish(image.at(60, 24)));
  const auto lone = image.at(50 + 2, 70);  // a feature without a match: a yellow circle around it
  EXPECT_GT(lone[0], 120);
  EXPECT_GT(lone[1], 100);
  EXPECT_LT(lone[2], 60);
  EXPECT_EQ(image.at(50, 70), (std::array<std::uint8_t, 3>{50, 50, 50}));
}

TEST(MatchImage, a_steep_line_is_as_closed_as_a_flat_one_and_green_lies_over_red) {
  const auto rgb = flat(40, 200, 0);
  const FeatureSet left = features_at({{38, 5}, {38, 195}}), right = features_at({{1, 195}, {1, 5}});
  const std::vector<mapping::Match> matches{{0, 0, 0}, {1, 1, 0}};
  const Image image =
      draw_matches({rgb, 40, 200, left}, {rgb, 40, 200, right}, matches, std::vector<std::uint8_t>{0, 1});
  for (int y = 10; y < 190; ++y) {
    int light = 0;  // wherever between two pixels the line runs, a row holds the same amount of it
    for (int x = 34; x < 46; ++x) light += image.at(x, y)[0] + image.at(x, y)[1];
    EXPECT_GT(light, 150) << y;
    EXPECT_LT(light, 800) << y;
  }
  EXPECT_GT(image.at(40, 100)[1], image.at(40, 100)[0]) << "the crossing";
}

TEST(MatchImage, features_on_the_rim_and_no_matches_are_fine) {
  const auto rgb = flat(8, 8, 9);
  const FeatureSet set = features_at({{0, 0}, {7, 7}, {-3, 20}});
  const Image image = draw_matches({rgb, 8, 8, set}, {rgb, 8, 8, set}, {}, {});
  EXPECT_EQ(image.rgb.size(), 3u * 16 * 8);
}

}  // namespace
}  // namespace onemap::render
