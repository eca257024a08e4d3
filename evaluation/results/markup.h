#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace uniquadric {

/// Text for between the tags of HTML and SVG: & < > by their names.
std::string escaped(const std::string& text);

/// Text inside a cell of a markdown table, where it is nothing but text: no tag, link or emphasis.
std::string markdown_cell(const std::string& text);

/// Plain text: columns padded to their widest cell, each to the side that `sides` has a character for: '<'
/// left, else, and beyond its end, right. At least one line, all as long as the first.
std::string aligned_columns(const std::vector<std::vector<std::string>>& lines, std::string_view sides);

}  // namespace uniquadric
