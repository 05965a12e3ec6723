#pragma once
#include <string>

#include "hal/base/result.hpp"
#include "render/scene.hpp"

namespace onemap::render {

// Writes the scene as binary glTF 2.0 (.glb). Nodes: a root with the scene's title, whose rotation makes the scene's up
// (up_of) glTF's +y, and below it "map" (triangles or points), and for every robot "trajectory NAME" (a line
// strip) and "cameras NAME" with one child node a keyframe, whose translation and rotation are T_scene_camera.
// Materials are unlit: the colours are photographed light. The map's is single-sided, so that one looks through walls
// into the room. Whole or not at all.
Status write_glb(const std::string& path, const Scene& scene);

// Reads what write_glb() wrote. A trajectory comes back as positions: its poses have no rotation.
Result<Scene> read_glb(const std::string& path);

}  // namespace onemap::render
