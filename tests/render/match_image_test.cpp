#include "render/match_image.hpp"

#include <gtest/gtest.h>

#include <algorithm>

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

// Images of different height, so that the corner below the smaller one must stay black.
TEST(MatchImage, kept_matches_are_green_rejected_red_and_the_photographs_stay) {
  const auto left_rgb = flat(100, 80, 50), right_rgb = flat(90, 60, 70);
  const FeatureSet left = features_at({{20, 20}, {20, 50}, {50, 70}}), right = features_at({{40, 20}, {30, 50}});
  const std::vector<mapping::Match> matches{{0, 0, 5}, {1, 1, 9}};
  const Image image =
      draw_matches({left_rgb, 100, 80, left}, {right_rgb, 90, 60, right}, matches, std::vector<std::uint8_t>{1, 0});
  ASSERT_EQ(image.width, 196);  // with the seam
  ASSERT_EQ(image.height, 92);  // and the strip of words
  EXPECT_EQ(image.at(5, 5), (std::array<std::uint8_t, 3>{50, 50, 50}));
  EXPECT_EQ(image.at(191, 5), (std::array<std::uint8_t, 3>{70, 70, 70}));
  EXPECT_EQ(image.at(150, 75), (std::array<std::uint8_t, 3>{250, 250, 250}));
  EXPECT_EQ(image.at(102, 40), (std::array<std::uint8_t, 3>{250, 250, 250})) << "the seam";
  for (int x = 30; x < 97; ++x) EXPECT_TRUE(greenish(image.at(x, 20))) << x;  // from (20, 20) to (146, 20)
  for (int x = 30; x < 97; ++x)
    EXPECT_GT(image.at(x, 50)[0], image.at(x, 50)[1] + 60) << x;  // from (20, 50) to (136, 50)
  EXPECT_FALSE(greenish(image.at(60, 24)));
}

TEST(MatchImage, a_steep_line_is_as_closed_as_a_flat_one_and_green_lies_over_red) {
  const auto rgb = flat(40, 200, 0);
  const FeatureSet left = features_at({{38, 5}, {38, 195}}), right = features_at({{1, 195}, {1, 5}});
  const std::vector<mapping::Match> matches{{0, 0, 0}, {1, 1, 0}};
  const Image image =
      draw_matches({rgb, 40, 200, left}, {rgb, 40, 200, right}, matches, std::vector<std::uint8_t>{0, 1});
  for (int y = 10; y < 190; ++y) {
    int coloured = 0;  // over the seam too
    for (int x = 34; x < 50; ++x)
      coloured += image.at(x, y)[2] + 40 < std::max(image.at(x, y)[0], image.at(x, y)[1]) ? 1 : 0;
    EXPECT_GE(coloured, 2) << y;
    EXPECT_LE(coloured, 10) << y;
  }
  EXPECT_GT(image.at(42, 100)[1], image.at(42, 100)[0]) << "the crossing";
}

// A hundred matches side by side: the lines that are drawn are few, and spread over the whole photograph.
TEST(MatchImage, of_many_matches_an_even_choice_is_drawn) {
  const auto rgb = flat(400, 300, 0);
  FeatureSet set;
  std::vector<mapping::Match> matches;
  for (int i = 0; i < 290; ++i) {
    mapping::Keypoint k;
    k.x_px = static_cast<float>(5 + 390 * (i % 10) / 10);
    k.y_px = static_cast<float>(i + 5);
    set.keypoints.push_back(k);
    set.descriptors.emplace_back();
    matches.push_back({static_cast<std::uint16_t>(i), static_cast<std::uint16_t>(i), 0});
  }
  const Image image =
      draw_matches({rgb, 400, 300, set, 3}, {rgb, 400, 300, set, 40}, matches, std::vector<std::uint8_t>(290, 1));
  std::size_t crossings = 0;
  int highest = 300, lowest = 0;
  for (int y = 0; y < 300; ++y) {
    if (!greenish(image.at(403, y)) || greenish(image.at(403, y - 1 < 0 ? 0 : y - 1))) continue;
    ++crossings;
    highest = std::min(highest, y);
    lowest = std::max(lowest, y);
  }
  EXPECT_GT(crossings, 12u);  // some lie on each other
  EXPECT_LE(crossings, kMostKeptLines);
  EXPECT_LT(highest, 50);
  EXPECT_GT(lowest, 250);
}

TEST(MatchImage, features_on_the_rim_and_no_matches_are_fine) {
  const auto rgb = flat(8, 8, 9);
  const FeatureSet set = features_at({{0, 0}, {7, 7}, {-3, 20}});
  const Image image = draw_matches({rgb, 8, 8, set}, {rgb, 8, 8, set}, {}, {});
  EXPECT_EQ(image.rgb.size(), 3u * 22 * 20);
}

}  // namespace
}  // namespace onemap::render
