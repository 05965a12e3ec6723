#pragma once
#include <cstdint>
#include <span>

#include "mapping/local/features.hpp"
#include "render/image.hpp"

namespace onemap::render {

// One photograph with its features.
struct MatchSide {
  std::span<const std::uint8_t> rgb;  // 3 * width * height, rows from the top
  int width = 0, height = 0;
  const mapping::FeatureSet& features;
  std::uint64_t frame = 0;  // its number, for the words below
};

// Of these at most so many are drawn, spread evenly over the left photograph.
constexpr std::size_t kMostKeptLines = 60, kMostRejectedLines = 20;

// The paper's figure 4: two photographs side by side with a light seam between them, kept matches joined by green lines
// and rejected ones by thin red lines below them, and a strip below that counts all of them. kept[i] != 0 tells about
// matches[i]; both spans have the same length.
Image draw_matches(const MatchSide& left, const MatchSide& right, std::span<const mapping::Match> matches,
                   std::span<const std::uint8_t> kept);

}  // namespace onemap::render
