#pragma once
#include <string>

#include "hal/base/result.hpp"
#include "mapping/mesh.hpp"

namespace onemap::render {

// Binary PCD 0.7, as PCL and Open3D read it: x y z (float, metres) and rgb (0x00rrggbb, in a float as PCL has it), a
// point a vertex of the mesh. Colours are empty or as many as there are points (they then default to grey). Points are
// turned by R_file_map, as in PLY files (upright_rotation()); a comment says so. Whole or not at all.
Status write_pcd(const std::string& path, const mapping::TriangleMesh& mesh,
                 const mapping::Matrix3d& R_file_map = mapping::Matrix3d::Identity());
Status write_pcd(const std::string& path, const mapping::ColoredCloud& cloud,
                 const mapping::Matrix3d& R_file_map = mapping::Matrix3d::Identity());

}  // namespace onemap::render
