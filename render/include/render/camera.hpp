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
  float near_m = 0.05f, far_m = 100.0f;

  glm::mat4 view() const;
  glm::mat4 projection(float aspect) const;  // aspect = width / height
};

// Named viewpoints.
//   fit     the room as the cameras saw it: along their mean viewing direction, from behind and above, all in view
//   top     straight from above ("up" is the mean of the cameras' -y), all in view
//   front   from just behind the first keyframe of the first robot: what it saw
//   follow  over the shoulder of the first robot's last pose
enum class View { fit, top, front, follow };
std::optional<View> view_from_name(std::string_view name);

// The viewpoint for a picture of width / height = aspect. "All" is what lies within the 2nd and 98th percentile of the
// map along the three axes, so a few stray points do not shrink the room, and every path. A scene without paths is
// looked at from its frame's origin along +z; an empty scene gives a valid camera too.
Camera make_camera(const Scene& scene, View view, float aspect);

// Looks from eye to target with the scene's up (if the two are parallel: some other up); near and far enclose the
// scene.
Camera make_camera(const Scene& scene, const glm::vec3& eye, const glm::vec3& target);

}  // namespace onemap::render
