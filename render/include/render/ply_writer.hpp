#pragma once
#include <string>

#include "hal/base/result.hpp"
#include "mapping/mesh.hpp"

namespace onemap::render {

// Binary little-endian PLY: vertex x y z [nx ny nz] red green blue, and for a mesh the faces as lists of three indices.
// Normals and colours are empty or as many as there are points (colours then default to grey). Points are turned by
// R_file_map (upright_rotation(): viewers take +y for up); a comment of the header says so, and read_ply() turns them
// back. Whole or not at all.
Status write_ply(const std::string& path, const mapping::TriangleMesh& mesh,
                 const mapping::Matrix3d& R_file_map = mapping::Matrix3d::Identity());
Status write_ply(const std::string& path, const mapping::ColoredCloud& cloud,
                 const mapping::Matrix3d& R_file_map = mapping::Matrix3d::Identity());

}  // namespace onemap::render
