// Simulated robots of one team: where they meet, what they share, and that places which nothing joins look different.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "hal/backends/simulated.hpp"
#include "seen_frames.hpp"

namespace onemap::hal {
namespace {

using test::Agreement;
using test::Seen;
using test::SeenPicture;

double overlap(const Seen& a, const Seen& b) {
  const Agreement got = test::compare(a, b);
  return static_cast<double>(got.same) / got.sampled;
}

TEST(SimulatedTeam, RobotsStartApartAndSeeTheSameThings) {
  for (const std::string scene : {"living-room", "office", "storage", "empty-hall"}) {
    std::vector<std::vector<Seen>> robots;
    for (int robot = 1; robot <= 3; ++robot)
      robots.push_back(
          test::see("simulated:" + scene + "?noise=none&fps=1&robot=" + std::to_string(robot), {0, 1, 2, 3, 4, 5}));
    for (const auto& [a, b] : {std::pair<std::size_t, std::size_t>{0, 1}, {1, 2}, {0, 2}}) {
      double best = 0;
      for (const Seen& x : robots[a])
        for (const Seen& y : robots[b]) best = std::max(best, overlap(x, y));
      EXPECT_GT(best, 0.6) << scene << " robots " << a + 1 << " and " << b + 1;
    }
    const double first = overlap(robots[0][0], robots[1][0]);
    EXPECT_GT(first, 0.15) << scene;
    EXPECT_LT(first, 0.85) << scene;
  }
}

// Three robots in the house: neighbours see the same at their passage, the outer two share little, and each is
// in free space and turns no faster than a hand.
TEST(SimulatedTeam, RobotsOfTheHouseMeetAtTwoPlaces) {
  std::vector<std::vector<Seen>> robots;
  std::set<std::uint64_t> all;
  for (std::uint64_t i = 0; i < 108; ++i) all.insert(i);
  for (int robot = 1; robot <= 3; ++robot)
    robots.push_back(test::see(
        "simulated:house?noise=none&fps=6&width=160&height=120&frames=108&robot=" + std::to_string(robot), all));
  for (const auto& frames : robots)
    for (std::size_t i = 0; i < frames.size(); ++i) {
      EXPECT_GT(*std::ranges::min_element(frames[i].picture.depth), 0.35 * 5000) << i;
      if (i == 0) continue;
      double cosine = 0;
      for (std::size_t c = 0; c < 4; ++c)
        cosine += frames[i].pose.q_world_camera_xyzw[c] * frames[i - 1].pose.q_world_camera_xyzw[c];
      EXPECT_LT(2 * std::acos(std::min(1.0, std::abs(cosine))) * 6 * 57.2958, 60) << i;
    }
  double all_of_last = 0;  // overlap over all pairs of frames
  const auto best = [&](std::size_t a, std::size_t b) {
    double most = 0;
    all_of_last = 0;
    for (std::size_t i = 0; i < 108; i += 4)
      for (std::size_t j = 0; j < 108; j += 4) {
        const double here = overlap(robots[a][i], robots[b][j]);
        most = std::max(most, here);
        all_of_last += here / (27 * 27);
      }
    return most;
  };
  EXPECT_GT(best(0, 1), 0.5);
  EXPECT_GT(best(1, 2), 0.5);
  best(0, 2);
  EXPECT_LT(all_of_last, 0.1) << "each has a room of its own";
}

// A square piece of a picture, grey, mean 0 and length 1; `contrast` is its standard deviation before.
constexpr int kSide = 21, kPixels = kSide * kSide, kViewWidth = 320, kViewHeight = 240;
struct Piece {
  std::array<float, kPixels> values{};
  float contrast = 0;

  Piece(const SeenPicture& p, int x, int y) {
    float mean = 0, squares = 0;
    for (int i = 0; i < kPixels; ++i) {
      const auto at = 3 * static_cast<std::size_t>((y + i / kSide) * kViewWidth + x + i % kSide);
      values[static_cast<std::size_t>(i)] = static_cast<float>(p.rgb[at] + p.rgb[at + 1] + p.rgb[at + 2]) / 3;
    }
    for (const float v : values) mean += v / kPixels;
    for (const float v : values) squares += (v - mean) * (v - mean);
    contrast = std::sqrt(squares / kPixels);
    const float scale = 1 / std::sqrt(squares + 1e-3f);
    for (float& v : values) v = (v - mean) * scale;
  }

  // Gradients in more than one direction (a straight edge looks like every other): the structure tensor's smaller
  // eigenvalue is not small beside the larger.
  bool corner() const {
    float xx = 0, xy = 0, yy = 0;
    for (int y = 1; y + 1 < kSide; ++y) {
      for (int x = 1; x + 1 < kSide; ++x) {
        const float* v = values.data() + y * kSide + x;
        const float dx = v[1] - v[-1], dy = v[kSide] - v[-kSide];
        xx += dx * dx;
        xy += dx * dy;
        yy += dy * dy;
      }
    }
    const float spread = std::sqrt((xx - yy) * (xx - yy) + 4 * xy * xy);
    return contrast > 12 && xx + yy - spread > 0.4f * (xx + yy + spread);
  }
};

// The share of a's pieces with structure that are found anywhere in b with a correlation over 0.9: an independent
// stand-in for feature matching.
double likeness(const SeenPicture& a, const SeenPicture& b) {
  std::vector<Piece> wanted;
  for (int y = 20; y < kViewHeight - 40; y += 24)
    for (int x = 20; x < kViewWidth - 40; x += 24)
      if (const Piece piece(a, x, y); piece.corner()) wanted.push_back(piece);
  EXPECT_GT(wanted.size(), 15u);
  std::vector<float> best(wanted.size(), -1.0f);
  for (int y = 0; y + kSide <= kViewHeight; ++y) {
    for (int x = 0; x + kSide <= kViewWidth; ++x) {
      const Piece here(b, x, y);
      for (std::size_t n = 0; n < wanted.size(); ++n) {
        float sum = 0;
        for (std::size_t i = 0; i < kPixels; ++i) sum += wanted[n].values[i] * here.values[i];
        best[n] = std::max(best[n], sum);
      }
    }
  }
  return static_cast<double>(std::ranges::count_if(best, [](float v) { return v > 0.9f; })) /
         static_cast<double>(best.size());
}

TEST(SimulatedTeam, PlacesWithoutOverlapDoNotLookAlike) {
  const std::string size = "&width=320&height=240";
  const auto room = test::take("simulated:living-room?robot=1" + size, {0, 10});
  const auto other = test::take("simulated:storage?robot=1" + size, {40});
  const auto seed = test::take("simulated:living-room?robot=1&seed=9" + size, {0});
  EXPECT_GT(likeness(room[0], room[1]), 0.5);
  EXPECT_LT(likeness(room[0], other[0]), 0.1);
  EXPECT_LT(likeness(room[0], seed[0]), 0.1);
}

}  // namespace
}  // namespace onemap::hal
