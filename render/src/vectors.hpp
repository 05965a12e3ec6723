#pragma once
#include <glm/vec3.hpp>

#include "mapping/geometry.hpp"

namespace onemap::render {

inline glm::vec3 to_glm(const mapping::Vector3f& v) { return {v.x(), v.y(), v.z()}; }
inline glm::vec3 to_glm(const mapping::Vector3d& v) { return to_glm(mapping::Vector3f(v.cast<float>())); }

}  // namespace onemap::render
