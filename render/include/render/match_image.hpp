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
};

// The paper's figure 4: two photographs side by side, every feature a small circle, kept matches joined by green lines
// and rejected ones by red lines below them. kept[i] != 0 tells about matches[i]; both spans have the same length.
Image draw_matches(const MatchSide& left, const MatchSide& right, std::span<const mapping::Match> matches,
                   std::span<const std::uint8_t> kept);

}  // namespace onemap::render
