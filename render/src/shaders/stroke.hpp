#pragma once

// Trajectories and camera pyramids. Lines wider than a pixel are not portable, so every segment is a quad that the
// vertex shader spans on the screen, with round ends, and half a pixel more for a smooth rim.
namespace onemap::render::shaders {

inline constexpr const char* kStrokeVertex = R"(#version 300 es
layout(location = 0) in vec3 from;     // per instance
layout(location = 1) in vec3 to;
layout(location = 2) in vec4 color;
layout(location = 3) in float width_px;
uniform mat4 view_projection;
uniform vec2 half_size_px;
uniform float near_m;
out vec2 v_local_px;
flat out float v_length_px;
flat out float v_radius_px;
flat out vec4 v_color;
void main() {
  vec4 a = view_projection * vec4(from, 1.0);
  vec4 b = view_projection * vec4(to, 1.0);
  if (a.w < near_m && b.w < near_m) {
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    return;
  }
  if (a.w < near_m) a = mix(a, b, (near_m - a.w) / (b.w - a.w));
  if (b.w < near_m) b = mix(b, a, (near_m - b.w) / (a.w - b.w));
  vec2 a_px = a.xy / a.w * half_size_px;
  vec2 b_px = b.xy / b.w * half_size_px;
  v_length_px = distance(a_px, b_px);
  vec2 along = v_length_px > 0.001 ? (b_px - a_px) / v_length_px : vec2(1.0, 0.0);
  vec2 across = vec2(-along.y, along.x);
  v_radius_px = 0.5 * width_px;
  bool at_b = (gl_VertexID & 1) == 1;
  float side = (gl_VertexID & 2) == 2 ? 1.0 : -1.0;
  float reach_px = v_radius_px + 0.5;
  v_local_px = vec2(at_b ? v_length_px + reach_px : -reach_px, side * reach_px);
  v_color = color;
  vec2 p_px = a_px + along * v_local_px.x + across * v_local_px.y;
  vec4 end = at_b ? b : a;
  gl_Position = vec4(p_px / half_size_px * end.w, end.z, end.w);
}
)";

inline constexpr const char* kStrokeFragment = R"(#version 300 es
precision highp float;
in vec2 v_local_px;
flat in float v_length_px;
flat in float v_radius_px;
flat in vec4 v_color;
uniform float opacity;
uniform bool smooth_rim;
out vec4 out_color;
void main() {
  float beyond = max(max(-v_local_px.x, v_local_px.x - v_length_px), 0.0);
  float inside_px = v_radius_px - length(vec2(beyond, v_local_px.y));
  float covered = smooth_rim ? clamp(inside_px + 0.5, 0.0, 1.0) : step(0.0, inside_px);
  if (covered <= 0.0) discard;
  out_color = vec4(v_color.rgb, v_color.a * opacity * covered);
}
)";

// The translucent faces of the camera pyramids.
inline constexpr const char* kFaceVertex = R"(#version 300 es
layout(location = 0) in vec3 position;
layout(location = 2) in vec4 color;
uniform mat4 view_projection;
out vec4 v_color;
void main() {
  v_color = color;
  gl_Position = view_projection * vec4(position, 1.0);
}
)";

inline constexpr const char* kFaceFragment = R"(#version 300 es
precision mediump float;
in vec4 v_color;
out vec4 out_color;
void main() { out_color = v_color; }
)";

}  // namespace onemap::render::shaders
