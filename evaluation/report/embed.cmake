# Turns text files into one C++ source: page_asset("name") gives a file's text.
# usage: cmake -DOUT=FILE.cpp "-DASSETS=FILE;FILE" -P embed.cmake
set(source "#include <cassert>\n\n#include \"evaluation/report/page_assets.h\"\n\nnamespace uniquadric {\n\n")
string(APPEND source "std::string_view page_asset(std::string_view name) {\n")
foreach(asset IN LISTS ASSETS)
  get_filename_component(name "${asset}" NAME)
  file(READ "${asset}" text)
  if(text MATCHES "\\)embedded\"")
    message(FATAL_ERROR "${asset} holds the text that ends a literal")
  endif()
  string(APPEND source "  if (name == \"${name}\")\n    return R\"embedded(${text})embedded\";\n")
endforeach()
string(APPEND source "  assert(!\"no such asset\");\n  return {};\n}\n\n}  // namespace uniquadric\n")
file(WRITE "${OUT}" "${source}")
