#pragma once
#include <optional>
#include <span>
#include <vector>

#include "render/image.hpp"
#include "render/scene.hpp"

namespace onemap::render {

// How far each vertex of `of` is from the surface of `to`, metres, at most limit_m: the nearest vertex, and where that
// has a normal and lies close by, the distance from the plane through it.
std::vector<float> distances_m(const mapping::TriangleMesh& of, const mapping::TriangleMesh& to, float limit_m);

// What a list of distances comes to. Empty: zeros.
struct DistanceSummary {
  float median_m = 0, p95_m = 0;
  float beyond = 0;  // share at or beyond the limit
};
DistanceSummary summary(std::vector<float> distances, float limit_m);

// T_scene_other, where a robot of the same name has keyframes in both: what brings them together best, all of them (the
// first, where there are not equally many). nullopt: nothing in common.
std::optional<mapping::Pose> motion_between(const Scene& scene, const Scene& other);

// The other scene moved by that: a robot's local map and the team's then lie on each other, and what is left is where
// they differ. Nothing in common: the other scene as it is.
Scene in_frame_of(Scene other, const Scene& scene);

// Dark blue for 0, over green and yellow, to red for the limit and beyond.
mapping::Rgb distance_color(float distance_m, float limit_m);

// The colours' scale at the right rim, in centimetres.
void draw_distance_scale(Image& image, float limit_m);

}  // namespace onemap::render
