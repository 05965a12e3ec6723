#include "egl_context.hpp"

#include <EGL/eglext.h>
#include <fmt/format.h>

#include <array>
#include <cstring>
#include <string_view>

namespace onemap::render {
namespace {

bool has_extension(const char* list, std::string_view name) {
  std::string_view rest = list != nullptr ? list : "";
  while (!rest.empty()) {
    const std::size_t size = std::min(rest.find(' '), rest.size());
    if (rest.substr(0, size) == name) return true;
    rest.remove_prefix(std::min(size + 1, rest.size()));
  }
  return false;
}

EGLDisplay first_device() {
  const auto query = reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(eglGetProcAddress("eglQueryDevicesEXT"));
  std::array<EGLDeviceEXT, 8> devices{};
  EGLint count = 0;
  if (query == nullptr || query(static_cast<EGLint>(devices.size()), devices.data(), &count) == EGL_FALSE) count = 0;
  for (EGLint i = 0; i < count; ++i) {
    const EGLDisplay display =
        eglGetPlatformDisplay(EGL_PLATFORM_DEVICE_EXT, devices[static_cast<std::size_t>(i)], nullptr);
    if (display != EGL_NO_DISPLAY && eglInitialize(display, nullptr, nullptr) == EGL_TRUE) return display;
  }
  return EGL_NO_DISPLAY;
}

EGLDisplay open_display() {
  const char* client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  if (has_extension(client, "EGL_MESA_platform_surfaceless")) {
    const EGLDisplay display = eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr);
    if (display != EGL_NO_DISPLAY && eglInitialize(display, nullptr, nullptr) == EGL_TRUE) return display;
  }
  return has_extension(client, "EGL_EXT_platform_device") ? first_device() : EGL_NO_DISPLAY;
}

Error egl_error(const char* what) {
  return Error{"EGL", fmt::format("{} (error 0x{:04x})", what, static_cast<unsigned>(eglGetError()))};
}

}  // namespace

// The display is never terminated: EGL shares it among all contexts of the process, and another one may still draw.
Result<std::unique_ptr<EglContext>> EglContext::open() {
  const EGLDisplay display = open_display();
  if (display == EGL_NO_DISPLAY)
    return egl_error("no driver that draws without a display (surfaceless or device platform); libegl-mesa0 has one");
  if (!has_extension(eglQueryString(display, EGL_EXTENSIONS), "EGL_KHR_surfaceless_context"))
    return egl_error("the driver needs a surface");
  if (eglBindAPI(EGL_OPENGL_ES_API) != EGL_TRUE) return egl_error("no OpenGL ES");
  const std::array<EGLint, 5> wanted{EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_ES3_BIT, EGL_NONE};
  EGLConfig config{};
  EGLint count = 0;
  if (eglChooseConfig(display, wanted.data(), &config, 1, &count) != EGL_TRUE || count == 0)
    return egl_error("no configuration with OpenGL ES 3");
  const std::array<EGLint, 3> version{EGL_CONTEXT_MAJOR_VERSION, 3, EGL_NONE};
  const EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, version.data());
  if (context == EGL_NO_CONTEXT) return egl_error("no OpenGL ES 3 context");
  return std::unique_ptr<EglContext>(new EglContext(display, context));
}

EglContext::~EglContext() { eglDestroyContext(display_, context_); }

EglContext::Current::Current(const EglContext& context)
    : display_(context.display_),
      ok_(eglBindAPI(EGL_OPENGL_ES_API) == EGL_TRUE &&
          eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context.context_) == EGL_TRUE) {}

EglContext::Current::~Current() { eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT); }

}  // namespace onemap::render
