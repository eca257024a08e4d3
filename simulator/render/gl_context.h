#pragma once

#include <memory>

namespace uniquadric {

/// An OpenGL 4.5 core context without a window. Everything that draws sees this interface alone, so that
/// another off-screen library can stand beside OSMesa. A context belongs to the thread that makes it current;
/// contexts of several threads draw at the same time.
class GlContext {
 public:
  GlContext() = default;
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;
  virtual ~GlContext() = default;

  /// Directs the calling thread's OpenGL calls to this context.
  virtual void make_current() = 0;
  using Function = void (*)();
  /// An OpenGL function by its full name ("glClear"); null when the library does not have it.
  virtual Function function(const char* name) const = 0;
};

/// A new context of Mesa's off-screen library (llvmpipe), not yet current. Throws std::runtime_error when the
/// library cannot make one. Unless they are set, it sets LP_NATIVE_VECTOR_WIDTH=256 (512 crashes, and images
/// shall not depend on the machine more than needed) and LP_NUM_THREADS=0 (a context rasterises in the thread
/// that owns it: whoever wants two threads draws with two contexts) in the environment; Mesa reads both once,
/// when the first context of the process is made.
std::unique_ptr<GlContext> make_osmesa_context();

}  // namespace uniquadric
