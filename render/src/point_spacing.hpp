#pragma once
#include <span>

#include "mapping/geometry.hpp"

namespace onemap::render {

// The typical distance of a point to its nearest neighbour (median over a few of them), metres; 0 below two points.
float point_spacing_m(std::span<const mapping::Vector3f> points);

}  // namespace onemap::render
