#pragma once
#include <cstdint>
#include <span>
#include <string>

#include "hal/base/result.hpp"
#include "mapping/mesh.hpp"

namespace onemap::render {

// Reads PLY, binary little-endian or ascii: x y z, and if present nx ny nz, red green blue (8 bits); polygons become
// triangle fans; anything else is skipped. A turn that write_ply() noted is undone. No faces: a point cloud, with its
// points as vertices. Any input gives a mesh whose indices are valid, or an error that names the place.
Result<mapping::TriangleMesh> read_ply(const std::string& path);
Result<mapping::TriangleMesh> parse_ply(std::span<const std::uint8_t> bytes, const std::string& name);

}  // namespace onemap::render
