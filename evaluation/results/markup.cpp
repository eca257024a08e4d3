#include "evaluation/results/markup.h"

#include <fmt/format.h>

#include <algorithm>

namespace uniquadric {

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else
      result += c;
  }
  return result;
}

std::string markdown_cell(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (std::string_view("\\|`*[]<>&").find(c) != std::string_view::npos) result += '\\';
    result += c;
  }
  return result;
}

std::string aligned_columns(const std::vector<std::vector<std::string>>& lines, std::string_view sides) {
  std::vector<std::size_t> width(lines.front().size());
  for (const auto& line : lines)
    for (std::size_t i = 0; i < line.size(); ++i) width[i] = std::max(width[i], line[i].size());
  std::string text;
  for (const auto& line : lines) {
    std::string row;
    for (std::size_t i = 0; i < line.size(); ++i)
      row += i < sides.size() && sides[i] == '<' ? fmt::format("{:<{}}  ", line[i], width[i])
                                                 : fmt::format("{:>{}}  ", line[i], width[i]);
    row.erase(row.find_last_not_of(' ') + 1);
    text += row + "\n";
  }
  return text;
}

}  // namespace uniquadric
