#include <GL/glcorearb.h>  // before osmesa.h, which otherwise pulls in OpenGL 1.x
// clang-format off: the order matters
#include <GL/osmesa.h>
// clang-format on

#include <array>
#include <stdexcept>

#include "simulator/render/gl_context.h"

namespace uniquadric {
namespace {

class OsmesaContext : public GlContext {
 public:
  OsmesaContext() {
    constexpr std::array attributes = {OSMESA_FORMAT,
                                       OSMESA_RGBA,
                                       OSMESA_DEPTH_BITS,
                                       0,
                                       OSMESA_STENCIL_BITS,
                                       0,
                                       OSMESA_PROFILE,
                                       OSMESA_CORE_PROFILE,
                                       OSMESA_CONTEXT_MAJOR_VERSION,
                                       4,
                                       OSMESA_CONTEXT_MINOR_VERSION,
                                       5,
                                       0};
    context_ = OSMesaCreateContextAttribs(attributes.data(), nullptr);
    if (!context_) throw std::runtime_error("OSMesa cannot make an OpenGL 4.5 core context");
  }
  ~OsmesaContext() override { OSMesaDestroyContext(context_); }

  void make_current() override {
    if (OSMesaGetCurrentContext() == context_) return;
    if (!OSMesaMakeCurrent(context_, window_.data(), GL_UNSIGNED_BYTE, kWindowSide, kWindowSide))
      throw std::runtime_error("OSMesa cannot make its context current");
  }
  Function function(const char* name) const override { return OSMesaGetProcAddress(name); }

 private:
  static constexpr int kWindowSide =
      16;  // px: OSMesa wants a window, all drawing goes to framebuffer objects
  OSMesaContext context_ = nullptr;
  std::array<unsigned char, 4 * kWindowSide * kWindowSide> window_{};
};

}  // namespace

std::unique_ptr<GlContext> make_osmesa_context() {
  return std::make_unique<OsmesaContext>();
}

}  // namespace uniquadric
