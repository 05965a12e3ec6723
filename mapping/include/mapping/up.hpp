#pragma once
#include <span>

#include "mapping/geometry.hpp"

namespace onemap::mapping {

// A piece of surface; any frame, metres.
struct Facet {
  Vector3f point, normal;  // unit
  float weight = 1;        // its area, in any unit that all facets share
};

// Which way is up: the normal, on the prior's side, of the dominant plane nearest to the prior (floors, table tops,
// ceilings), fitted through its points; the prior itself where there is no such plane. The prior, a unit vector, may be
// half a right angle off: a camera that looks down at a desk has an up of its own. Pure: equal facets, equal answer.
Vector3f up_of(std::span<const Facet> facets, const Vector3f& prior);

}  // namespace onemap::mapping
