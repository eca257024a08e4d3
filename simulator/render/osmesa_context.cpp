#include <GL/glcorearb.h>  // before osmesa.h, which otherwise pulls in OpenGL 1.x
// clang-format off: the order matters
#include <GL/osmesa.h>
// clang-format on

#include <array>
#include <stdexcept>

#include "core/base/error.h"
#include "core/base/on_demand.h"
#include "simulator/render/gl_context.h"

namespace uniquadric {
namespace {

// The library is loaded with the first context: it brings LLVM along, which most commands do without.
struct Osmesa {
#define UNIQUADRIC_OSMESA_FUNCTION(name) decltype(&::name) name = load<decltype(::name)>(#name)
  UNIQUADRIC_OSMESA_FUNCTION(OSMesaCreateContextAttribs);
  UNIQUADRIC_OSMESA_FUNCTION(OSMesaDestroyContext);
  UNIQUADRIC_OSMESA_FUNCTION(OSMesaGetCurrentContext);
  UNIQUADRIC_OSMESA_FUNCTION(OSMesaMakeCurrent);
  UNIQUADRIC_OSMESA_FUNCTION(OSMesaGetProcAddress);
#undef UNIQUADRIC_OSMESA_FUNCTION

  template <typename Function>
  static Function* load(const char* name) {
    return function_on_demand<Function>("libOSMesa.so.8", name);
  }
};

const Osmesa& osmesa() {
  static const Osmesa functions;
  return functions;
}

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
    context_ = osmesa().OSMesaCreateContextAttribs(attributes.data(), nullptr);
    if (!context_) throw InputError("OSMesa cannot make an OpenGL 4.5 core context");
  }
  ~OsmesaContext() override { osmesa().OSMesaDestroyContext(context_); }

  void make_current() override {
    if (osmesa().OSMesaGetCurrentContext() == context_) return;
    if (!osmesa().OSMesaMakeCurrent(context_, window_.data(), GL_UNSIGNED_BYTE, kWindowSide, kWindowSide))
      throw std::runtime_error("OSMesa cannot make its context current");
  }
  Function function(const char* name) const override { return osmesa().OSMesaGetProcAddress(name); }

 private:
  static constexpr int kWindowSide =
      16;  // px: OSMesa wants a window, all drawing goes to framebuffer objects
  OSMesaContext context_ = nullptr;
  std::array<unsigned char, 4 * kWindowSide * kWindowSide> window_{};
};

}  // namespace

void load_osmesa() {
  osmesa();
}

std::unique_ptr<GlContext> make_osmesa_context() {
  return std::make_unique<OsmesaContext>();
}

}  // namespace uniquadric
