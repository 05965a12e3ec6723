#pragma once

// The map: triangles or points, lit mildly so that photographed colours stay recognisable.
namespace onemap::render::shaders {

inline constexpr const char* kSurfaceVertex = R"(#version 300 es
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;   // zero: unknown
layout(location = 2) in vec3 color;
uniform mat4 view_projection;
uniform vec3 eye;
uniform float point_px_at_1m;          // 0: triangles
uniform bool both_sides;
out vec3 v_position;
out vec3 v_normal;
out vec3 v_color;
void main() {
  v_position = position;
  v_normal = normal;
  v_color = color;
  gl_Position = view_projection * vec4(position, 1.0);
  gl_PointSize = clamp(point_px_at_1m / max(gl_Position.w, 0.001), 1.0, 64.0);
  bool from_behind = dot(normal, position - eye) > 0.0;
  if (point_px_at_1m > 0.0 && from_behind && !both_sides) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
}
)";

inline constexpr const char* kSurfaceFragment = R"(#version 300 es
precision highp float;
in vec3 v_position;
in vec3 v_normal;
in vec3 v_color;
uniform vec3 eye;
uniform vec3 up;
uniform float point_px_at_1m;
uniform float shading;
out vec4 out_color;
void main() {
  vec3 normal = v_normal;
  float known = 1.0;
  if (dot(normal, normal) < 0.01) {
    normal = cross(dFdx(v_position), dFdy(v_position));
    if (point_px_at_1m > 0.0 || dot(normal, normal) == 0.0) known = 0.0;
  }
  vec3 light = normalize(normalize(eye - v_position) + 0.6 * up);
  float brightness = known > 0.0 ? 0.2 + 0.8 * abs(dot(normalize(normal), light)) : 1.0;
  out_color = vec4(v_color * mix(1.0, brightness, shading), 1.0);
}
)";

}  // namespace onemap::render::shaders
