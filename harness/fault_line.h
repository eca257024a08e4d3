#pragma once

#include <exception>
#include <string>

namespace uniquadric {

/// What the program says of an exception that is no bad input: "out of memory", or "internal error: ...",
/// with a request to report it.
std::string fault_line(const std::exception& e);

}  // namespace uniquadric
