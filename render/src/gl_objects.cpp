#include "gl_objects.hpp"

#include <array>
#include <string>

namespace onemap::render {
namespace {

// Compiles and attaches; the shader lives as long as the program that it is attached to.
std::string attach(GLuint program, GLenum kind, const char* source) {
  const GLuint shader = glCreateShader(kind);
  glShaderSource(shader, 1, &source, nullptr);
  glCompileShader(shader);
  GLint ok = GL_FALSE;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
  std::array<char, 1024> log{};
  if (ok != GL_TRUE) glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
  glAttachShader(program, shader);
  glDeleteShader(shader);
  return log.data();
}

GlRenderbuffer make_renderbuffer(GLenum format, int width, int height, int samples) {
  GLuint name = 0;
  glGenRenderbuffers(1, &name);
  glBindRenderbuffer(GL_RENDERBUFFER, name);
  glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, format, width, height);
  return GlRenderbuffer(name);
}

}  // namespace

Result<GlProgram> build_program(const char* name, const char* vertex_source, const char* fragment_source) {
  GlProgram program(glCreateProgram());
  std::string log = attach(program.get(), GL_VERTEX_SHADER, vertex_source);
  log += attach(program.get(), GL_FRAGMENT_SHADER, fragment_source);
  glLinkProgram(program.get());
  GLint ok = GL_FALSE;
  glGetProgramiv(program.get(), GL_LINK_STATUS, &ok);
  if (ok != GL_TRUE) return Error{std::string("shader ") + name, "the driver refuses it: " + log};
  return program;
}

GlBuffer make_buffer(GLenum target, const void* data, std::size_t size_bytes) {
  GLuint name = 0;
  glGenBuffers(1, &name);
  glBindBuffer(target, name);
  glBufferData(target, static_cast<GLsizeiptr>(size_bytes), data, GL_STREAM_DRAW);
  return GlBuffer(name);
}

GlVertexArray make_vertex_array() {
  GLuint name = 0;
  glGenVertexArrays(1, &name);
  glBindVertexArray(name);
  return GlVertexArray(name);
}

RenderTarget make_render_target(int width, int height, int samples) {
  RenderTarget target;
  GLuint name = 0;
  glGenFramebuffers(1, &name);
  target.framebuffer = GlFramebuffer(name);
  target.color = make_renderbuffer(GL_RGBA8, width, height, samples);
  target.depth = make_renderbuffer(GL_DEPTH24_STENCIL8, width, height, samples);
  glBindFramebuffer(GL_FRAMEBUFFER, name);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, target.color.get());
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, target.depth.get());
  target.complete = glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
  return target;
}

RenderTarget make_resolved_target(int width, int height) {
  RenderTarget target;
  GLuint name = 0;
  glGenFramebuffers(1, &name);
  target.framebuffer = GlFramebuffer(name);
  target.color = make_renderbuffer(GL_RGBA8, width, height, 0);
  GLuint texture = 0;
  glGenTextures(1, &texture);
  target.depth_texture = GlTexture(texture);
  glBindTexture(GL_TEXTURE_2D, texture);
  glTexStorage2D(GL_TEXTURE_2D, 1, GL_DEPTH24_STENCIL8, width, height);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glBindFramebuffer(GL_FRAMEBUFFER, name);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, target.color.get());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_TEXTURE_2D, texture, 0);
  target.complete = glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
  return target;
}

}  // namespace onemap::render
