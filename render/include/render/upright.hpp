#pragma once
#include "render/scene.hpp"

namespace onemap::render {

// Which way is up, as a unit vector in the scene's frame: the scene's own, else mapping::up_of() of the scene's surface
// and the cameras' mean up. Without surface: the cameras' mean up; without cameras as well: -y. Pure: the same scene
// gives the same answer.
mapping::Vector3f up_of(const Scene& scene);

// Turns the scene's frame so that `up` becomes +y; what lies ahead (+z) becomes -z as far as that leaves it: what glTF
// and most viewers call upright. For up = -y: half a turn about x.
mapping::Matrix3d upright_rotation(const mapping::Vector3f& up);

// The points and normals turned; everything else as it was.
mapping::TriangleMesh turned(mapping::TriangleMesh mesh, const mapping::Matrix3d& R);
mapping::ColoredCloud turned(mapping::ColoredCloud cloud, const mapping::Matrix3d& R);

}  // namespace onemap::render
