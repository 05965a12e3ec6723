#pragma once

// Hollows and edges from the depth of the picture itself. On a plane 1/z is a straight line in the pixel, so the mean
// of two opposite neighbours minus the middle is zero there, however steeply it is seen; it is positive in a hollow and
// negative on a ridge. (After Luft, Colditz, Deussen, "Image Enhancement by Unsharp Masking the Depth Buffer", 2006.)
namespace onemap::render::shaders {

inline constexpr const char* kDepthCuesVertex = R"(#version 300 es
void main() {  // one triangle over the whole picture
  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}
)";

inline constexpr const char* kDepthCuesFragment = R"(#version 300 es
precision highp float;
uniform highp sampler2D depth;
uniform float near_m;
uniform float far_m;
uniform bool orthographic;
uniform float pixels_at_1m;   // that a metre spans at 1 m, or everywhere when orthographic
uniform float strength;
out vec4 out_color;

const float kRadius_m = 0.12;  // of a hollow
const float kReach_m = 0.10;   // difference of depth that counts most; what lies far before or behind counts little

ivec2 last;
float raw(ivec2 at) { return texelFetch(depth, clamp(at, ivec2(0), last), 0).r; }

// Odd, so that on a plane opposite neighbours still cancel.
float weighed(float step_m) {
  float x = step_m / kReach_m;
  return 2.0 * x / (1.0 + x * x);
}

void main() {
  last = textureSize(depth, 0) - 1;
  ivec2 here = ivec2(gl_FragCoord.xy);
  float d = raw(here);
  if (d >= 1.0) discard;
  // metres towards the eye = (d - other) * scale
  float range = far_m - near_m;
  float z = orthographic ? near_m + d * range : 1.0 / (1.0 / near_m - d * range / (far_m * near_m));
  float scale = orthographic ? range : z * z * range / (far_m * near_m);
  float radius = clamp(kRadius_m * pixels_at_1m / (orthographic ? 1.0 : z), 3.0, 48.0);
  const vec2 kDirections[6] = vec2[](vec2(1.0, 0.0), vec2(0.433, 0.25), vec2(0.35, 0.606), vec2(0.0, 0.5),
                                     vec2(-0.5, 0.866), vec2(-0.606, 0.35));
  float hollow = 0.0;
  for (int i = 0; i < 6; ++i) {
    ivec2 offset = ivec2(round(radius * kDirections[i]));
    float sum = weighed((d - raw(here + offset)) * scale) + weighed((d - raw(here - offset)) * scale);
    hollow += max(sum, -0.3);
  }
  float ridge = 0.0;
  for (int i = 0; i < 2; ++i) {
    ivec2 offset = i == 0 ? ivec2(1, 0) : ivec2(0, 1);
    float a = clamp((d - raw(here + offset)) * scale, -kReach_m, kReach_m);
    float b = clamp((d - raw(here - offset)) * scale, -kReach_m, kReach_m);
    ridge = max(ridge, -(a + b));
  }
  float dark = 0.75 * smoothstep(0.28, 0.95, hollow / 6.0) + 0.4 * smoothstep(0.3, 1.0, ridge / kReach_m);
  out_color = vec4(vec3(1.0 - strength * min(dark, 1.0)), 1.0);
}
)";

}  // namespace onemap::render::shaders
