#include "render/drawing.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <set>

#include "render/figures.hpp"

namespace onemap::render {
namespace {

constexpr Color kWhite{255, 255, 255}, kBlack{0, 0, 0};

Image written(const std::string& text) {
  Image image(static_cast<int>(text_width_px(text, 24)) + 20, 48, kWhite);
  draw_text(image, {10, 34}, text, 24, kBlack);
  return image;
}

TEST(Drawing2d, every_character_is_legible_and_no_two_are_alike) {
  std::set<std::string> seen;
  for (char c = '!'; c <= '~'; ++c) {
    Image image(60, 48, kWhite);
    draw_text(image, {10, 34}, std::string(1, c), 24, kBlack);
    std::size_t ink = 0;
    for (const std::uint8_t v : image.rgb) ink += v < 128 ? 1 : 0;
    EXPECT_GT(ink, 15u) << c;
    EXPECT_TRUE(seen.insert(std::string(image.rgb.begin(), image.rgb.end())).second) << c;
  }
}

TEST(Drawing2d, text_stays_within_its_width_and_height) {
  for (const std::string text : {"robot1", "1 234 567 triangles", "Qgjpy|", "\xc3\xa9"}) {
    const Image image = written(text);
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) {
        const bool outside = x < 7 || x > image.width - 8 || y < 34 - 24 - 3 || y > 34 + 8 + 3;
        ASSERT_TRUE(!outside || image.at(x, y) == kWhite) << text << " at " << x << ", " << y;
      }
  }
  EXPECT_EQ(text_width_px("", 20), 0);
  EXPECT_GT(text_width_px("robot", 20), text_width_px("robo", 20));
}

TEST(Drawing2d, shapes_reach_over_the_rim_without_harm) {
  Image image(20, 10, kWhite);
  fill_rectangle(image, -5, -5, 8, 8, kBlack);
  EXPECT_EQ(image.at(2, 2), kBlack);
  EXPECT_EQ(image.at(3, 3), kWhite);
  fill_disc(image, {19, 9}, 3, kBlack);
  EXPECT_EQ(image.at(19, 9), kBlack);
  draw_line(image, {-50, 5}, {50, 5}, {255, 0, 0}, 1);
  EXPECT_EQ(image.at(10, 5), (Color{255, 0, 0}));
  paste(image, Image(4, 4, {0, 255, 0}), 18, -2);
  EXPECT_EQ(image.at(19, 0), (Color{0, 255, 0}));
  EXPECT_EQ(image.at(17, 0), kWhite);
}

TEST(TeamPicture, shows_robots_links_and_reasons_and_survives_what_is_not_there) {
  TeamPicture team;
  for (const std::string name : {"robot1", "robot2", "robot3"})
    team.robots.push_back({name, robot_color(team.robots.size()), 30, true});
  team.robots[2].in_map = false;
  const Image alone = draw_team(team, 800, 450);
  team.links = {{0, 1, true, 420, 12, ""}, {1, 2, false, 3, 1, "too few matches"}, {1, 9, true, 1, 1, ""}};
  team.reference = "robot1";
  const Image linked = draw_team(team, 800, 450);
  ASSERT_EQ(linked.width, 800);
  const auto count = [](const Image& image, auto&& is) {
    std::size_t n = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) n += is(image.at(x, y)) ? 1 : 0;
    return n;
  };
  const auto green = [](Color c) { return c[1] > c[0] + 50 && c[1] > c[2] + 30; };
  const auto first = [](Color c) { return c == robot_color(0); };
  EXPECT_GT(count(linked, green), count(alone, green) + 200);
  EXPECT_GT(count(linked, first), 300u);
  EXPECT_EQ(draw_team({}, 320, 180).rgb.size(), 3u * 320 * 180);
  for (int i = 0; i < 40; ++i)
    team.links.push_back({0, 2, false, 1, 0, "a reason that is as long as reasons can be, and longer"});
  EXPECT_EQ(draw_team(team, 320, 180).height, 180);
}

// Of robots that all know each other links cross; none hides another one's number.
TEST(TeamPicture, every_links_number_is_to_be_seen) {
  const auto differ = [](const Image& a, const Image& b) {
    std::size_t pixels = 0;
    for (int y = 0; y < a.height; ++y)  // without the list
      for (int x = 0; x < a.width * 6 / 10; ++x) pixels += std::abs(a.at(x, y)[0] - b.at(x, y)[0]) > 100 ? 1 : 0;
    return pixels;
  };
  for (const std::size_t robots : {4, 5, 6}) {
    TeamPicture team;
    for (std::size_t i = 0; i < robots; ++i) team.robots.push_back({"robot" + std::to_string(i + 1), kBlack, 30, true});
    for (std::size_t i = 0; i < robots; ++i)
      for (std::size_t j = i + 1; j < robots; ++j) team.links.push_back({i, j, true, 91111, 1, ""});
    const Image all = draw_team(team);
    for (auto& link : team.links) {
      link.inliers = 98989;
      EXPECT_GT(differ(draw_team(team), all), 20u) << robots << ": " << link.a << " - " << link.b;
      link.inliers = 91111;
    }
  }
}

TEST(TeamPicture, names_lie_on_no_link) {
  TeamPicture team;
  for (std::size_t i = 0; i < 4; ++i) team.robots.push_back({"robot" + std::to_string(i + 1), kBlack, 30, true});
  team.links = {{0, 1, true, 9, 1, ""}, {1, 2, true, 9, 1, ""}, {2, 3, true, 9, 1, ""}, {0, 3, true, 9, 1, ""}};
  const Image linked = draw_team(team);
  team.links.clear();
  const Image alone = draw_team(team);
  for (int y = 0; y < alone.height; ++y)
    for (int x = 0; x < alone.width * 6 / 10; ++x) {
      const bool letter = alone.at(x, y)[0] < 60 && alone.at(x, y)[1] > 20;  // ink, not a robot's disc
      if (letter) {
        ASSERT_EQ(linked.at(x, y), alone.at(x, y)) << x << ", " << y;
      }
    }
}

TEST(TeamPicture, what_is_said_of_a_link_stays_within_the_picture) {
  TeamPicture team;
  team.robots = {{"the-kitchens-robot", kBlack, 30, true}, {"the-cellars-robot", kBlack, 30, true}};
  const Image without = draw_team(team);
  for (const bool accepted : {true, false}) {
    team.links = {{0, 1, accepted, 123456, 1024, "much would lie side by side without a link"}};
    const Image with = draw_team(team);
    bool said = false;
    for (int y = 0; y < with.height / 2; ++y) {
      for (int x = with.width * 6 / 10; x < with.width; ++x) said = said || with.at(x, y) != without.at(x, y);
      for (int x = with.width - 12; x < with.width; ++x) ASSERT_EQ(with.at(x, y), without.at(x, y)) << x << ", " << y;
    }
    EXPECT_TRUE(said);
  }
}

}  // namespace
}  // namespace onemap::render
