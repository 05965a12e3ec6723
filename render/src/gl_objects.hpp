#pragma once
#include <GLES3/gl3.h>

#include <cstddef>
#include <span>
#include <utility>

#include "hal/base/result.hpp"

namespace onemap::render {

// An OpenGL name that is deleted with its owner; the context must be current then.
template <auto Delete>
class GlName {
 public:
  explicit GlName(GLuint name = 0) : name_(name) {}
  ~GlName() {
    if (name_ != 0) Delete(name_);
  }
  GlName(GlName&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
  GlName& operator=(GlName&& other) noexcept {
    std::swap(name_, other.name_);
    return *this;
  }
  GLuint get() const { return name_; }

 private:
  GLuint name_;
};

inline void delete_buffer(GLuint name) { glDeleteBuffers(1, &name); }
inline void delete_vertex_array(GLuint name) { glDeleteVertexArrays(1, &name); }
inline void delete_framebuffer(GLuint name) { glDeleteFramebuffers(1, &name); }
inline void delete_renderbuffer(GLuint name) { glDeleteRenderbuffers(1, &name); }
inline void delete_texture(GLuint name) { glDeleteTextures(1, &name); }
inline void delete_program(GLuint name) { glDeleteProgram(name); }

using GlBuffer = GlName<delete_buffer>;
using GlVertexArray = GlName<delete_vertex_array>;
using GlFramebuffer = GlName<delete_framebuffer>;
using GlRenderbuffer = GlName<delete_renderbuffer>;
using GlTexture = GlName<delete_texture>;
using GlProgram = GlName<delete_program>;

Result<GlProgram> build_program(const char* name, const char* vertex_source, const char* fragment_source);

// A new buffer with these bytes, left bound to the target.
GlBuffer make_buffer(GLenum target, const void* data, std::size_t size_bytes);
GlVertexArray make_vertex_array();  // left bound

// A colour and depth-stencil target of a size, with samples for smooth edges (0: none).
struct RenderTarget {
  GlFramebuffer framebuffer;
  GlRenderbuffer color, depth;
  GlTexture depth_texture;  // instead of `depth` where a shader reads it
  bool complete = false;
};
RenderTarget make_render_target(int width, int height, int samples);
RenderTarget make_resolved_target(int width, int height);  // without samples, its depth a texture

}  // namespace onemap::render
