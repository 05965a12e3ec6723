#include "render/camera.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <utility>

namespace onemap::render {

glm::mat4 Camera::view() const { return glm::lookAt(eye, target, up); }

glm::mat4 Camera::projection(float aspect) const {
  if (height_m <= 0) return glm::perspective(fov_y_rad, aspect, near_m, far_m);
  const float half = 0.5f * height_m;
  return glm::ortho(-half * aspect, half * aspect, -half, half, near_m, far_m);
}

float Camera::metres_per_pixel(const glm::vec3& point, int height_px) const {
  const auto pixels = static_cast<float>(height_px);
  if (height_m > 0) return height_m / pixels;
  const float depth = std::max(glm::dot(point - eye, glm::normalize(target - eye)), near_m);
  return 2 * depth * std::tan(0.5f * fov_y_rad) / pixels;
}

std::optional<View> view_from_name(std::string_view name) {
  static constexpr std::array<std::pair<std::string_view, View>, 5> kNames{
      {{"fit", View::fit}, {"top", View::top}, {"plan", View::plan}, {"front", View::front}, {"follow", View::follow}}};
  for (const auto& [text, view] : kNames)
    if (text == name) return view;
  return std::nullopt;
}

Camera turned_about_target(const Camera& camera, const mapping::Vector3f& up, float turns) {
  const glm::vec3 axis{up.x(), up.y(), up.z()};
  const glm::mat4 turn = glm::rotate(glm::mat4(1.0f), turns * 6.2831853f, axis);
  Camera out = camera;
  out.eye = camera.target + glm::vec3(turn * glm::vec4(camera.eye - camera.target, 0.0f));
  out.up = glm::vec3(turn * glm::vec4(camera.up, 0.0f));
  return out;
}

}  // namespace onemap::render
