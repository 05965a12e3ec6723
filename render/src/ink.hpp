#pragma once
// The colours of words and lines in figures, and of what has no colour of its own.
#include "mapping/geometry.hpp"
#include "render/image.hpp"

namespace onemap::render {

inline constexpr Color kInk{35, 38, 42}, kSoftInk{120, 125, 132};
inline constexpr mapping::Rgb kUncoloured{180, 180, 180};

}  // namespace onemap::render
