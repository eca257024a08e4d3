#include "simulator/render/gl_functions.h"

#define GL_GLEXT_PROTOTYPES  // for their types alone: the functions come from the context
#include <GL/glcorearb.h>
#include <fmt/format.h>

#include <stdexcept>
#include <type_traits>

namespace uniquadric {

#define UNIQUADRIC_GL_TYPE_CHECK(name, ...) \
  static_assert(std::is_same_v<decltype(GlFunctions::name), decltype(&::gl##name)>);
UNIQUADRIC_GL_FUNCTIONS(UNIQUADRIC_GL_TYPE_CHECK)
#undef UNIQUADRIC_GL_TYPE_CHECK

GlFunctions load_gl_functions(const GlContext& context) {
  GlFunctions gl;
#define UNIQUADRIC_GL_LOAD(name, ...)                                          \
  gl.name = reinterpret_cast<decltype(gl.name)>(context.function("gl" #name)); \
  if (!gl.name) throw std::runtime_error("the OpenGL library has no function gl" #name);
  UNIQUADRIC_GL_FUNCTIONS(UNIQUADRIC_GL_LOAD)
#undef UNIQUADRIC_GL_LOAD
  return gl;
}

void check_gl(const GlFunctions& gl, const char* what) {
  if (const GLenum error = gl.GetError(); error != GL_NO_ERROR)
    throw std::runtime_error(fmt::format("{}: OpenGL error 0x{:04x}", what, error));
}

}  // namespace uniquadric
