#pragma once
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string_view>

#include "render/scene.hpp"

namespace onemap::render {

// From where a picture is taken. All in the scene's frame, metres.
struct Camera {
  glm::vec3 eye{0, 0, 0};
  glm::vec3 target{0, 0, 1};
  glm::vec3 up{0, -1, 0};  // scenes are y down
  float fov_y_rad = 0.87f;
  float height_m = 0;  // > 0: orthographic; so many metres fit into the picture's height
  float near_m = 0.05f, far_m = 100.0f;

  glm::mat4 view() const;
  glm::mat4 projection(float aspect) const;  // aspect = width / height
  // Metres that one pixel spans at a point, in a picture of so many pixels height.
  float metres_per_pixel(const glm::vec3& point, int height_px) const;
};

// Named viewpoints. Up is up_of() the scene.
//   fit     the room as the cameras saw it, from behind and above along their mean viewing direction; where they looked
//           all around: as a doll's house, from the side that shows most, along its walls where that shows as much
//   top     straight from above, in perspective, turned so that the map fills the picture
//   plan    the same, orthographic: a floor plan
//   front   from just behind the first keyframe of the first robot: what it saw
//   follow  over the shoulder of the first robot's last pose
enum class View { fit, top, plan, front, follow };
std::optional<View> view_from_name(std::string_view name);

// The viewpoint for a picture of width / height = aspect. fit, top and plan have everything in view that is drawn
// (surface that faces the eye, paths, camera pyramids) with a border of 8 % and no more; the farthest 0.3 % of the map
// along each of the three axes does not count, so that a few stray points do not shrink the room. A scene without paths
// is looked at from its frame's origin along +z; an empty scene gives a valid camera too.
Camera make_camera(const Scene& scene, View view, float aspect);

// As `fit` does, but in this direction: neither need be level or a unit vector, in the scene's frame.
Camera fit_along(const Scene& scene, const glm::vec3& forward, const glm::vec3& up, float aspect);

// From the same height and tilt as `camera`, turned about the vertical through its target by so many turns.
Camera turned_about_target(const Camera& camera, const mapping::Vector3f& up, float turns);

// `camera` at such a distance from its target that the whole map is in view from all sides of a turn.
Camera with_room_to_turn(const Scene& scene, const Camera& camera, float aspect);

// Looks from eye to target with the scene's up (if the two are parallel: some other up); near and far enclose the
// scene.
Camera make_camera(const Scene& scene, const glm::vec3& eye, const glm::vec3& target);

// Over the shoulder of a pose, looking where it looks; near and far enclose the scene.
Camera camera_behind(const Scene& scene, const mapping::Pose& pose);

}  // namespace onemap::render
