#pragma once

namespace uniquadric {

/// A symbol of a shared library, which the first such call loads: of libraries that take long to load and
/// that most commands do without. `library` is its soname. Throws std::runtime_error where either is not
/// found.
void* symbol_on_demand(const char* library, const char* symbol);

template <typename Function>
Function* function_on_demand(const char* library, const char* symbol) {
  return reinterpret_cast<Function*>(symbol_on_demand(library, symbol));
}

}  // namespace uniquadric
