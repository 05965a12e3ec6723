#pragma once
#include <optional>
#include <span>
#include <vector>

#include "mapping/geometry.hpp"
#include "mapping/records/depth_grid.hpp"
#include "mapping/up.hpp"

namespace onemap::mapping {

// Pieces of the surface that a keyframe sees, in the map's frame: a few hundred of a grid, none across depth steps,
// normals towards the camera, weights in square metres as seen. Appends to `out`.
void add_facets(const DepthGrid& grid, const Pose& T_map_keyframe, std::vector<Facet>& out);

// The map's frame as robots that drive want it, T_level_map: z is up, the floor is z = 0, x is ahead of the map's own
// frame (its z), as far as the nearest direction of walls, and the origins lie above each other. `up` is the
// map's (up_of). The floor is the lowest height at which a notable part of all surface lies that faces up; nothing
// where none does.
std::optional<Pose> level_frame(std::span<const Facet> facets, const Vector3f& up);

}  // namespace onemap::mapping
