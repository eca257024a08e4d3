#define EGL_NO_X11
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <fmt/format.h>

#include <array>

#include "core/base/error.h"
#include "simulator/render/gl_context.h"

namespace uniquadric {
namespace {

[[noreturn]] void fail(const char* what) {
  throw InputError(fmt::format(
      "EGL cannot {} (error 0x{:04x}); Mesa's (libegl-mesa0) can, and OSMesa (--gl osmesa) needs no EGL",
      what, eglGetError()));
}

// The display that has no screen. It is the same for all of a process's contexts and stays open to its end.
EGLDisplay open_display() {
  const EGLDisplay display =
      eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
  if (display == EGL_NO_DISPLAY || !eglInitialize(display, nullptr, nullptr))
    fail("open a display without a screen");
  return display;
}

class EglContext : public GlContext {
 public:
  EglContext() : display_(open_display()) {
    constexpr std::array attributes = {EGL_CONTEXT_MAJOR_VERSION,
                                       4,
                                       EGL_CONTEXT_MINOR_VERSION,
                                       5,
                                       EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                       EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                       EGL_NONE};
    if (!eglBindAPI(EGL_OPENGL_API)) fail("speak OpenGL");
    context_ = eglCreateContext(display_, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes.data());
    if (context_ == EGL_NO_CONTEXT) fail("make an OpenGL 4.5 core context");
  }
  ~EglContext() override {
    if (eglGetCurrentContext() == context_)
      eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
  }

  void make_current() override {
    if (eglGetCurrentContext() == context_) return;
    if (!eglBindAPI(EGL_OPENGL_API) ||  // each thread has its own choice
        !eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_))
      fail("make its context current");
  }
  Function function(const char* name) const override { return eglGetProcAddress(name); }

 private:
  EGLDisplay display_;
  EGLContext context_ = EGL_NO_CONTEXT;
};

}  // namespace

std::unique_ptr<GlContext> make_egl_context() {
  return std::make_unique<EglContext>();
}

}  // namespace uniquadric
