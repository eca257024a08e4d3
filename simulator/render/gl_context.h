#pragma once

#include <memory>

namespace uniquadric {

/// Where OpenGL comes from: Mesa's off-screen library, or EGL without a screen, which takes a graphics card
/// where there is one and llvmpipe otherwise. On llvmpipe both draw the same bytes. `automatic` is OSMesa
/// where it can be loaded (Mesa has none after 25.0), else EGL.
enum class GlLibrary { automatic, osmesa, egl };

/// OSMesa or EGL: what `library` stands for on this machine. `automatic` loads OSMesa, as load_osmesa does.
GlLibrary resolve_gl_library(GlLibrary library);

/// An OpenGL 4.5 core context without a window. Everything that draws sees this interface alone. A context
/// belongs to the thread that makes it current; contexts of several threads draw at the same time.
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

/// A new context, not yet current. Throws std::runtime_error when the library cannot make one. Unless they
/// are set, it sets LP_NATIVE_VECTOR_WIDTH=256 (512 crashes, and images shall not depend on the machine more
/// than needed) and LP_NUM_THREADS=0 (a context rasterises in the thread that owns it: whoever wants two
/// cores draws with two contexts, in two processes) in the environment; llvmpipe reads both once, when the
/// first context of the process is made.
std::unique_ptr<GlContext> make_gl_context(GlLibrary library);

/// Loads OSMesa, as the first of its contexts would: processes that are forked after it share its memory.
/// Throws std::runtime_error where it is not installed, or was not when this program was built.
void load_osmesa();

}  // namespace uniquadric
