// In the place of osmesa_context.cpp where there was no header of OSMesa.
#include "core/base/error.h"
#include "simulator/render/gl_context.h"

namespace uniquadric {

void load_osmesa() {
  throw InputError("this program was built without OSMesa (libosmesa6-dev); --gl egl draws the same");
}

std::unique_ptr<GlContext> make_osmesa_context() {
  load_osmesa();
  return nullptr;
}

}  // namespace uniquadric
