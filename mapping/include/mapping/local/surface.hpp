#pragma once
#include "mapping/local/voxel_map.hpp"
#include "mapping/mesh.hpp"

namespace onemap::mapping {

// Marching cubes (Lorensen and Cline 1987) over the zero level of the map; shared vertices are welded; colour and
// normal are interpolated. Voxels with less than min_weight do not count; one that is not seen is guessed where its
// direct neighbours say what a plane has there, so that grazing surfaces and rims close. Deterministic: the order
// follows the sorted blocks.
TriangleMesh extract_mesh(const VoxelMap& map, std::uint16_t min_weight = 2);

}  // namespace onemap::mapping
