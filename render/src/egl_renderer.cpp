#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <utility>

#include "egl_context.hpp"
#include "gl_objects.hpp"
#include "point_spacing.hpp"
#include "render/renderer.hpp"
#include "shaders/depth_cues.hpp"
#include "shaders/stroke.hpp"
#include "shaders/surface.hpp"
#include "smooth_edges.hpp"
#include "strokes.hpp"

namespace onemap::render {
namespace {

constexpr int kSamples = 4;
// Four samples take two to three times as long. Triangles of a few pixels show their edges only at the rims of things;
// there smooth_edges() does it.
constexpr std::size_t kTrianglesForOneSample = 50'000;
constexpr float kHiddenOpacity = 0.2f;  // of a path behind the map
constexpr float kPointOverlap = 1.25f;  // side of a point / spacing that closes a surface seen head-on

// The map's arrays, from whichever part of the scene is drawn.
struct Surface {
  std::span<const mapping::Vector3f> points, normals;
  std::span<const mapping::Rgb> colors;
  std::span<const std::array<std::uint32_t, 3>> triangles;  // empty: points
};

Surface surface_of(const Scene& scene, const Style& style) {
  const auto& mesh = scene.mesh;
  if (mesh.triangles.empty() && mesh.vertices.empty())
    return {scene.points.points, scene.points.normals, scene.points.colors, {}};
  Surface surface{mesh.vertices, mesh.normals, mesh.colors, mesh.triangles};
  if (style.points_only) surface.triangles = {};
  return surface;
}

std::string check(const Surface& s) {
  if (!s.normals.empty() && s.normals.size() != s.points.size()) return "normals for a part of the points only";
  if (!s.colors.empty() && s.colors.size() != s.points.size()) return "colours for a part of the points only";
  for (const auto& triangle : s.triangles)
    for (const std::uint32_t index : triangle)
      if (index >= s.points.size()) return fmt::format("a triangle with vertex {} of {}", index, s.points.size());
  return {};
}

// The map's arrays as vertex attributes where they are, in the vertex array that OpenGL ES begins with: a picture reads
// them once, so a copy in a buffer is time and memory for nothing.
class ClientArrays {
 public:
  ClientArrays() {
    glBindVertexArray(0);
    glBindBuffer(GL_ARRAY_BUFFER, 0);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, 0);
  }
  ~ClientArrays() {
    for (GLuint i = 0; i < count_; ++i) glDisableVertexAttribArray(i);
  }
  ClientArrays(const ClientArrays&) = delete;
  ClientArrays& operator=(const ClientArrays&) = delete;

  // The next attribute, or a constant where the map has none.
  template <class T>
  void add(std::span<const T> values, GLenum type, GLboolean normalized, float fallback) {
    const GLuint index = count_++;
    if (values.empty()) return glVertexAttrib3f(index, fallback, fallback, fallback);
    glEnableVertexAttribArray(index);
    glVertexAttribPointer(index, 3, type, normalized, sizeof(T), values.data());
  }

 private:
  GLuint count_ = 0;
};

// OpenGL passes an offset into the bound buffer as a pointer.
const void* at_byte(std::size_t offset) {
  return reinterpret_cast<const void*>(offset);  // NOLINT(performance-no-int-to-ptr)
}

GLint uniform(const GlProgram& program, const char* name) { return glGetUniformLocation(program.get(), name); }

// One picture's constants.
struct Shot {
  const Camera& camera;
  const Style& style;
  glm::mat4 view_projection;
  bool orthographic() const { return camera.height_m > 0; }
  float pixels_at_1m() const {
    const glm::vec3 there = camera.eye + glm::normalize(camera.target - camera.eye);
    return 1 / camera.metres_per_pixel(there, style.height_px);
  }
};

class EglRenderer final : public Renderer {
 public:
  EglRenderer(std::unique_ptr<EglContext> context, std::string description, GlProgram surface, GlProgram stroke,
              GlProgram face, GlProgram depth_cues)
      : context_(std::move(context)),
        description_(std::move(description)),
        surface_(std::move(surface)),
        stroke_(std::move(stroke)),
        face_(std::move(face)),
        depth_cues_(std::move(depth_cues)) {}
  ~EglRenderer() override {
    const EglContext::Current current(*context_);  // the programs are deleted in their context
    surface_ = GlProgram();
    stroke_ = GlProgram();
    face_ = GlProgram();
    depth_cues_ = GlProgram();
  }
  Result<Image> draw(const Scene& scene, const Camera& camera, const Style& style) override;
  std::string description() const override { return description_; }

 private:
  void draw_surface(const Surface& surface, const Shot& shot) const;
  void draw_depth_cues(const RenderTarget& target, const RenderTarget& resolved, const Shot& shot) const;
  void draw_paths(const PathShapes& shapes, const Shot& shot) const;
  void draw_strokes(const std::vector<Stroke>& strokes, float hidden_opacity, const Shot& shot) const;

  std::unique_ptr<EglContext> context_;
  std::string description_;
  GlProgram surface_, stroke_, face_, depth_cues_;
};

Status check_size(const Style& style) {
  std::array<GLint, 2> viewport{};
  GLint buffer = 0;
  glGetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport.data());
  glGetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &buffer);
  const GLint max_width = std::min(viewport[0], buffer), max_height = std::min(viewport[1], buffer);
  if (style.width_px >= 1 && style.height_px >= 1 && style.width_px <= max_width && style.height_px <= max_height)
    return success();
  return Error{"picture", fmt::format("{} x {} pixels; this device draws 1 x 1 to {} x {}", style.width_px,
                                      style.height_px, max_width, max_height)};
}

void begin(const RenderTarget& target, const Style& style) {
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer.get());
  glViewport(0, 0, style.width_px, style.height_px);
  const auto channel = [&](std::size_t c) { return static_cast<float>(style.background[c]) / 255.0f; };
  glClearColor(channel(0), channel(1), channel(2), 1);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LESS);
  glDepthMask(GL_TRUE);
}

// Resolves the samples, reads the pixels, and puts the top row first.
Image read_picture(const RenderTarget& from, const RenderTarget& resolved, const Style& style) {
  const int w = style.width_px, h = style.height_px;
  glBindFramebuffer(GL_READ_FRAMEBUFFER, from.framebuffer.get());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, resolved.framebuffer.get());
  glBlitFramebuffer(0, 0, w, h, 0, 0, w, h, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, resolved.framebuffer.get());
  Image image(w, h);
  std::vector<std::uint8_t> rgba(4 * static_cast<std::size_t>(w) * static_cast<std::size_t>(h));
  glReadPixels(0, 0, w, h, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
  const auto width = static_cast<std::size_t>(w), height = static_cast<std::size_t>(h);
  for (std::size_t y = 0; y < height; ++y) {
    const std::uint8_t* source = &rgba[4 * width * (height - 1 - y)];
    std::uint8_t* target = &image.rgb[3 * width * y];
    for (std::size_t x = 0; x < width; ++x) std::copy_n(source + 4 * x, 3, target + 3 * x);
  }
  return image;
}

float point_px_at_1m(const Surface& surface, const Shot& shot) {
  if (!surface.triangles.empty()) return 0;
  float size_m = shot.style.point_size_m;
  if (size_m <= 0) size_m = kPointOverlap * point_spacing_m(surface.points);
  return std::max(size_m * shot.pixels_at_1m(), 1e-6f);
}

}  // namespace

void EglRenderer::draw_surface(const Surface& surface, const Shot& shot) const {
  if (surface.points.empty()) return;
  glUseProgram(surface_.get());
  glUniformMatrix4fv(uniform(surface_, "view_projection"), 1, GL_FALSE, glm::value_ptr(shot.view_projection));
  glUniform3fv(uniform(surface_, "eye"), 1, glm::value_ptr(shot.camera.eye));
  const glm::vec3 up = glm::normalize(shot.camera.up);
  glUniform3fv(uniform(surface_, "up"), 1, glm::value_ptr(up));
  glUniform1f(uniform(surface_, "shading"), shot.style.shading);
  glUniform1f(uniform(surface_, "point_px_at_1m"), point_px_at_1m(surface, shot));
  glUniform1i(uniform(surface_, "both_sides"), shot.style.both_sides ? 1 : 0);
  ClientArrays arrays;
  arrays.add(surface.points, GL_FLOAT, GL_FALSE, 0);
  arrays.add(surface.normals, GL_FLOAT, GL_FALSE, 0);
  arrays.add(surface.colors, GL_UNSIGNED_BYTE, GL_TRUE, 0.7f);
  if (surface.triangles.empty()) {
    glDrawArrays(GL_POINTS, 0, static_cast<GLsizei>(surface.points.size()));
    return;
  }
  if (!shot.style.both_sides) glEnable(GL_CULL_FACE);
  glDrawRangeElements(GL_TRIANGLES, 0, static_cast<GLuint>(surface.points.size() - 1),
                      static_cast<GLsizei>(3 * surface.triangles.size()), GL_UNSIGNED_INT, surface.triangles.data());
  glDisable(GL_CULL_FACE);
}

// Multiplies the surface's colours by what its depth says.
void EglRenderer::draw_depth_cues(const RenderTarget& target, const RenderTarget& resolved, const Shot& shot) const {
  const int w = shot.style.width_px, h = shot.style.height_px;
  glBindFramebuffer(GL_READ_FRAMEBUFFER, target.framebuffer.get());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, resolved.framebuffer.get());
  glBlitFramebuffer(0, 0, w, h, 0, 0, w, h, GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer.get());
  glUseProgram(depth_cues_.get());
  glUniform1f(uniform(depth_cues_, "near_m"), shot.camera.near_m);
  glUniform1f(uniform(depth_cues_, "far_m"), shot.camera.far_m);
  glUniform1i(uniform(depth_cues_, "orthographic"), shot.orthographic() ? 1 : 0);
  glUniform1f(uniform(depth_cues_, "pixels_at_1m"), shot.pixels_at_1m());
  glUniform1f(uniform(depth_cues_, "strength"), shot.style.depth_cues);
  glUniform1i(uniform(depth_cues_, "depth"), 0);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, resolved.depth_texture.get());
  const GlVertexArray array = make_vertex_array();
  glDisable(GL_DEPTH_TEST);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ZERO, GL_SRC_COLOR);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glDisable(GL_BLEND);
  glEnable(GL_DEPTH_TEST);
}

void EglRenderer::draw_strokes(const std::vector<Stroke>& strokes, float hidden_opacity, const Shot& shot) const {
  if (strokes.empty()) return;
  glUseProgram(stroke_.get());
  glUniformMatrix4fv(uniform(stroke_, "view_projection"), 1, GL_FALSE, glm::value_ptr(shot.view_projection));
  glUniform2f(uniform(stroke_, "half_size_px"), 0.5f * static_cast<float>(shot.style.width_px),
              0.5f * static_cast<float>(shot.style.height_px));
  glUniform1f(uniform(stroke_, "near_m"), shot.camera.near_m);
  const GlVertexArray array = make_vertex_array();
  const GlBuffer buffer = make_buffer(GL_ARRAY_BUFFER, strokes.data(), strokes.size() * sizeof(Stroke));
  for (GLuint i = 0; i < 4; ++i) {
    glEnableVertexAttribArray(i);
    glVertexAttribDivisor(i, 1);
  }
  constexpr GLsizei kStride = sizeof(Stroke);
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, kStride, at_byte(offsetof(Stroke, from)));
  glVertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, kStride, at_byte(offsetof(Stroke, to)));
  glVertexAttribPointer(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, kStride, at_byte(offsetof(Stroke, color)));
  glVertexAttribPointer(3, 1, GL_FLOAT, GL_FALSE, kStride, at_byte(offsetof(Stroke, width_px)));
  const auto draw = [&](float opacity, bool smooth_rim) {
    glUniform1f(uniform(stroke_, "opacity"), opacity);
    glUniform1i(uniform(stroke_, "smooth_rim"), smooth_rim ? 1 : 0);
    glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<GLsizei>(strokes.size()));
  };
  // What the map hides shines through faintly; the stencil keeps overlapping strokes from adding up, and lets none have
  // a rim that would keep the next one out.
  if (hidden_opacity > 0) {
    glClear(GL_STENCIL_BUFFER_BIT);
    glDepthFunc(GL_GREATER);
    glEnable(GL_STENCIL_TEST);
    glStencilFunc(GL_EQUAL, 0, 0xFF);
    glStencilOp(GL_KEEP, GL_KEEP, GL_INCR);
    draw(hidden_opacity, false);
    glDisable(GL_STENCIL_TEST);
    glDepthFunc(GL_LESS);
  }
  draw(1.0f, true);
}

// The shapes write no depth: their layers are in the order of drawing.
void EglRenderer::draw_paths(const PathShapes& shapes, const Shot& shot) const {
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  glDepthMask(GL_FALSE);
  if (!shapes.faces.empty()) {
    glUseProgram(face_.get());
    glUniformMatrix4fv(uniform(face_, "view_projection"), 1, GL_FALSE, glm::value_ptr(shot.view_projection));
    const GlVertexArray array = make_vertex_array();
    const GlBuffer buffer = make_buffer(GL_ARRAY_BUFFER, shapes.faces.data(), shapes.faces.size() * sizeof(FaceVertex));
    glEnableVertexAttribArray(0);
    glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(FaceVertex), at_byte(offsetof(FaceVertex, position)));
    glEnableVertexAttribArray(2);
    glVertexAttribPointer(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, sizeof(FaceVertex), at_byte(offsetof(FaceVertex, color)));
    glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(shapes.faces.size()));
  }
  draw_strokes(shapes.edges, kHiddenOpacity, shot);
  draw_strokes(shapes.seams, 0, shot);
  draw_strokes(shapes.paths, kHiddenOpacity, shot);
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
}

Result<Image> EglRenderer::draw(const Scene& scene, const Camera& camera, const Style& style) {
  const Surface surface = surface_of(scene, style);
  if (auto wrong = check(surface); !wrong.empty()) return Error{"scene", wrong};
  const EglContext::Current current(*context_);
  if (!current.ok()) return Error{"EGL", "the context is lost"};
  if (auto size = check_size(style); !size) return size.error();
  GLint samples = 0;
  glGetIntegerv(GL_MAX_SAMPLES, &samples);
  const bool one_sample = surface.triangles.size() > kTrianglesForOneSample;
  const RenderTarget target =
      make_render_target(style.width_px, style.height_px, one_sample ? 0 : std::min(kSamples, samples));
  const RenderTarget resolved = make_resolved_target(style.width_px, style.height_px);
  if (!target.complete || !resolved.complete) return Error{"picture", "no memory for its pixels"};
  begin(target, style);
  const float aspect = static_cast<float>(style.width_px) / static_cast<float>(style.height_px);
  const Shot shot{camera, style, camera.projection(aspect) * camera.view()};
  draw_surface(surface, shot);
  if (style.depth_cues > 0) draw_depth_cues(target, resolved, shot);
  draw_paths(path_shapes(scene, camera, style), shot);
  Image image = read_picture(target, resolved, style);
  if (one_sample) smooth_edges(image);
  if (const GLenum code = glGetError(); code != GL_NO_ERROR)
    return Error{"OpenGL", code == GL_OUT_OF_MEMORY ? "out of memory" : fmt::format("error 0x{:04x}", code)};
  return image;
}

Result<std::unique_ptr<Renderer>> open_egl_renderer() {
  auto context = EglContext::open();
  if (!context) return context.error();
  const EglContext::Current current(**context);
  if (!current.ok()) return Error{"EGL", "the new context cannot be used"};
  const auto text = [](GLenum name) {
    const GLubyte* value = glGetString(name);
    return value != nullptr ? std::string(reinterpret_cast<const char*>(value)) : std::string("?");
  };
  auto surface = build_program("surface", shaders::kSurfaceVertex, shaders::kSurfaceFragment);
  if (!surface) return surface.error();
  auto stroke = build_program("stroke", shaders::kStrokeVertex, shaders::kStrokeFragment);
  if (!stroke) return stroke.error();
  auto face = build_program("face", shaders::kFaceVertex, shaders::kFaceFragment);
  if (!face) return face.error();
  auto depth_cues = build_program("depth cues", shaders::kDepthCuesVertex, shaders::kDepthCuesFragment);
  if (!depth_cues) return depth_cues.error();
  return std::unique_ptr<Renderer>(
      std::make_unique<EglRenderer>(std::move(*context), text(GL_RENDERER) + ", " + text(GL_VERSION),
                                    std::move(*surface), std::move(*stroke), std::move(*face), std::move(*depth_cues)));
}

}  // namespace onemap::render
