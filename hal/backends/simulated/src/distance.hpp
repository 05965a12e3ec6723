#pragma once
#include "scene.hpp"

namespace onemap::hal::simulated {

// How far a place is from the nearest surface of a scene, from its formulas, metres.
double distance_to(const Scene& scene, const Vec3& at);

}  // namespace onemap::hal::simulated
