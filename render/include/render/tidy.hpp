#pragma once
#include <cstddef>

#include "mapping/mesh.hpp"

namespace onemap::render {

// A piece of surface with fewer vertices than this is noise rather than a thing: at 2 cm it is smaller than a hand.
constexpr std::size_t kCrumbVertices = 200;

// The mesh without its crumbs: connected pieces (over shared vertices) of fewer than `smallest_piece` vertices, and
// vertices that no triangle uses. The largest piece always stays. Order is kept. A mesh without triangles comes back as
// it is.
mapping::TriangleMesh without_crumbs(mapping::TriangleMesh mesh, std::size_t smallest_piece = kCrumbVertices);

// Gives every exactly black vertex the mean colour of its coloured neighbours, outwards from them ring by ring. Such a
// vertex lies between two places that no camera coloured; a photographed black is never exactly 0, 0, 0 over an area.
// Pieces without any colour stay black.
void colour_black_vertices(mapping::TriangleMesh& mesh);

// Both: what pictures and models are made of.
mapping::TriangleMesh tidied(mapping::TriangleMesh mesh, std::size_t smallest_piece = kCrumbVertices);

}  // namespace onemap::render
