#pragma once
#include <string>

#include "hal/base/result.hpp"
#include "mapping/mesh.hpp"

namespace onemap::render {

// Binary little-endian PLY: vertex x y z [nx ny nz] red green blue, and for a mesh the faces as lists of three indices.
// Normals and colours are empty or as many as there are points (colours then default to grey). Whole or not at all.
Status write_ply(const std::string& path, const mapping::TriangleMesh& mesh);
Status write_ply(const std::string& path, const mapping::ColoredCloud& cloud);

}  // namespace onemap::render
