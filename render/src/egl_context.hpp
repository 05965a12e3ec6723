#pragma once
#include <EGL/egl.h>

#include <memory>

#include "hal/base/result.hpp"

namespace onemap::render {

// An OpenGL ES 3 context without a display or a surface.
class EglContext {
 public:
  static Result<std::unique_ptr<EglContext>> open();
  ~EglContext();
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

  // While it lives, the context is the calling thread's.
  class Current {
   public:
    explicit Current(const EglContext& context);
    ~Current();
    Current(const Current&) = delete;
    Current& operator=(const Current&) = delete;
    bool ok() const { return ok_; }

   private:
    EGLDisplay display_;
    bool ok_;
  };

 private:
  EglContext(EGLDisplay display, EGLContext context) : display_(display), context_(context) {}
  EGLDisplay display_;
  EGLContext context_;
};

}  // namespace onemap::render
