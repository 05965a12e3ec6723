#include "render/match_image.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <string>
#include <vector>

#include "render/drawing.hpp"

namespace onemap::render {
namespace {

constexpr Color kKept{40, 215, 80}, kRejected{235, 60, 50}, kImagePaper{250, 250, 250}, kImageInk{35, 38, 42};
constexpr int kSeam_px = 6, kColumns = 8, kRows = 6;

Image photograph(const MatchSide& side) {
  assert(side.rgb.size() == 3 * static_cast<std::size_t>(side.width) * static_cast<std::size_t>(side.height));
  Image image(side.width, side.height);
  std::copy(side.rgb.begin(), side.rgb.end(), image.rgb.begin());
  return image;
}

Point place(const MatchSide& side, std::size_t i, int x0) {
  const mapping::Keypoint& k = side.features.keypoints[i];
  return {k.x_px + static_cast<float>(x0), k.y_px};
}

// In turn the next match of every cell of the left photograph, in the order that they have.
std::vector<std::size_t> evenly(const MatchSide& left, std::span<const mapping::Match> matches,
                                const std::vector<std::size_t>& wanted, std::size_t most) {
  std::array<std::vector<std::size_t>, std::size_t{kColumns} * kRows> cells;
  for (const std::size_t i : wanted) {
    const mapping::Keypoint& k = left.features.keypoints[matches[i].a];
    const int column = std::clamp(static_cast<int>(k.x_px) * kColumns / std::max(left.width, 1), 0, kColumns - 1);
    const int row = std::clamp(static_cast<int>(k.y_px) * kRows / std::max(left.height, 1), 0, kRows - 1);
    cells[static_cast<std::size_t>(row * kColumns + column)].push_back(i);
  }
  std::vector<std::size_t> chosen;
  for (std::size_t round = 0; chosen.size() < std::min(most, wanted.size()); ++round)
    for (const auto& cell : cells)
      if (round < cell.size() && chosen.size() < most) chosen.push_back(cell[round]);
  return chosen;
}

void draw_words(Image& image, int top, const std::string& words) {
  const auto height = static_cast<float>(image.height - top);
  const float text = std::min(0.45f * height, 0.45f * height * 0.9f * static_cast<float>(image.width) /
                                                  std::max(text_width_px(words, 0.45f * height), 1.0f));
  const float left = 0.5f * (static_cast<float>(image.width) - text_width_px(words, text));
  draw_text(image, {left, static_cast<float>(top) + 0.5f * (height + text)}, words, text, kImageInk);
}

// "312 agree", and of how many a line is drawn where that is not all.
std::string counted(std::size_t matches, std::size_t most, const char* what) {
  return matches > most ? fmt::format("{} {} ({} drawn)", matches, what, most) : fmt::format("{} {}", matches, what);
}

}  // namespace

Image draw_matches(const MatchSide& left, const MatchSide& right, std::span<const mapping::Match> matches,
                   std::span<const std::uint8_t> kept) {
  assert(matches.size() == kept.size());
  const int right_x = left.width + kSeam_px, tall = std::max(left.height, right.height);
  Image image(right_x + right.width, tall + std::max(12, tall / 16), kImagePaper);
  paste(image, photograph(left), 0, 0);
  paste(image, photograph(right), right_x, 0);
  std::array<std::vector<std::size_t>, 2> by_kind;  // rejected, kept
  for (std::size_t i = 0; i < matches.size(); ++i) by_kind[kept[i] != 0 ? 1 : 0].push_back(i);
  for (const std::size_t good : {std::size_t{0}, std::size_t{1}}) {
    const Color color = good == 1 ? kKept : kRejected;
    for (const std::size_t i : evenly(left, matches, by_kind[good], good == 1 ? kMostKeptLines : kMostRejectedLines)) {
      const Point a = place(left, matches[i].a, 0), b = place(right, matches[i].b, right_x);
      draw_line(image, a, b, color, good == 1 ? 1.4f : 1.0f, good == 1 ? 0.8f : 0.55f);
      draw_circle(image, a, 3, color, 1.5f);
      draw_circle(image, b, 3, color, 1.5f);
    }
  }
  draw_words(image, tall,
             fmt::format("frames {} and {}: {} features matched, {}, {}", left.frame, right.frame, matches.size(),
                         counted(by_kind[1].size(), kMostKeptLines, "agree"),
                         counted(by_kind[0].size(), kMostRejectedLines, "do not")));
  return image;
}

}  // namespace onemap::render
