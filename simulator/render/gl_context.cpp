#include "simulator/render/gl_context.h"

#include <cstdlib>
#include <mutex>
#include <stdexcept>

namespace uniquadric {

// Declared here, as each stands in a file of its own beside its library's headers.
std::unique_ptr<GlContext> make_osmesa_context();
std::unique_ptr<GlContext> make_egl_context();

GlLibrary resolve_gl_library(GlLibrary library) {
  if (library != GlLibrary::automatic) return library;
  try {
    load_osmesa();
    return GlLibrary::osmesa;
  } catch (const std::runtime_error&) {
    return GlLibrary::egl;
  }
}

std::unique_ptr<GlContext> make_gl_context(GlLibrary library) {
  static std::once_flag once;
  std::call_once(once, [] {
    setenv("LP_NATIVE_VECTOR_WIDTH", "256", 0);
    setenv("LP_NUM_THREADS", "0", 0);
  });
  return resolve_gl_library(library) == GlLibrary::egl ? make_egl_context() : make_osmesa_context();
}

}  // namespace uniquadric
