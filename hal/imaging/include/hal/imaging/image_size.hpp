#pragma once
#include <cstddef>

#include "hal/frame.hpp"

namespace onemap::hal::imaging {

inline constexpr int kMostSide_px = 8192;  // of any image

struct ImageSize {
  int width = 0, height = 0;  // pixels
  std::size_t pixels() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
  bool operator==(const ImageSize&) const = default;
};

inline ImageSize size_of(const Intrinsics& k) { return {k.width, k.height}; }

}  // namespace onemap::hal::imaging
