#pragma once

#include <string>

namespace uniquadric {

/// Says "warning: TEXT" on stderr, as a line: of a result that should not be taken for a good one.
/// Thread-safe.
void warn(const std::string& text);

/// How many warnings the program has given.
int warnings_given();

}  // namespace uniquadric
