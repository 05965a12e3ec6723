#pragma once
#include "render/image.hpp"

namespace onemap::render {

// Softens the stairs along edges of a picture that was drawn with one sample a pixel, in the way of FXAA (Lottes,
// 2009): where brightness jumps, each pixel is mixed with those along the edge's direction. What has no edge stays as
// it is.
void smooth_edges(Image& image);

}  // namespace onemap::render
