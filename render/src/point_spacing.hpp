#pragma once
#include <span>

#include "mapping/geometry.hpp"

namespace onemap::render {

// The distance of a point to its third-nearest neighbour that nine of ten points keep below, metres; 0 below two
// points. A surface out of voxels has its points in clusters with gaps of up to a voxel: it is the gaps that points
// must close.
float point_spacing_m(std::span<const mapping::Vector3f> points);

}  // namespace onemap::render
