#pragma once
#include <cstdint>
#include <span>

#include "hal/base/time.hpp"
#include "mapping/local/features.hpp"

namespace onemap::mapping {

// The matches of a frame with the image that it was last compared with (the frame before or a keyframe, known by its
// time): figure 4. frame is nullptr when it was compared with none. Looks into the memory of who gave it.
struct MatchPicture {
  const FeatureSet* frame = nullptr;
  const FeatureSet* other = nullptr;
  FrameTime other_time{};
  std::span<const Match> matches;      // a: frame, b: other
  std::span<const std::uint8_t> kept;  // 1 kept, 0 rejected
};

}  // namespace onemap::mapping
