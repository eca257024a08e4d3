#include "core/base/on_demand.h"

#include <dlfcn.h>

#include "core/base/error.h"

namespace uniquadric {

void* symbol_on_demand(const char* library, const char* symbol) {
  void* const handle = dlopen(library, RTLD_LAZY | RTLD_LOCAL);  // stays loaded; a second call finds it
  void* const found = handle ? dlsym(handle, symbol) : nullptr;
  if (!found) throw InputError(dlerror());
  return found;
}

}  // namespace uniquadric
