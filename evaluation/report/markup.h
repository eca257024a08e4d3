#pragma once

#include <string>

namespace uniquadric {

/// Text for between the tags of HTML and SVG: & < > by their names.
std::string escaped(const std::string& text);

}  // namespace uniquadric
