#include "simulator/scene/ply_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <set>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/text.h"

namespace uniquadric {
namespace {

struct Element {
  int line = 0;
  std::string_view name;
  long long count = 0;
  std::vector<bool> is_list;  // of its properties
};

struct Header {
  bool ascii = false;
  std::vector<Element> elements;
  std::size_t end = 0;  ///< bytes up to the body
  int lines = 0;        ///< up to there
};

// Goes on to the next line, whichever way it ends: its words.
std::vector<std::string_view> next_line(std::string_view bytes, std::size_t& at) {
  const std::size_t stop = std::min(bytes.find_first_of("\r\n", at), bytes.size());
  const auto fields = split(bytes.substr(at, stop - at));
  at = std::min(bytes.size(), stop + (bytes.substr(stop, 2) == "\r\n" ? 2 : 1));
  return fields;
}

bool is_ply(std::string_view bytes) {
  return bytes.size() >= 3 && (bytes[0] == 'p' || bytes[0] == 'P') && (bytes[1] == 'l' || bytes[1] == 'L') &&
         (bytes[2] == 'y' || bytes[2] == 'Y');
}

Element read_element(const std::vector<std::string_view>& fields, const std::filesystem::path& path,
                     int line) {
  const auto count = fields.size() == 3 ? parse_integer(fields[2]) : std::nullopt;
  // Figures at the start of a name are a count to assimp.
  if (!count || *count < 0 || !std::isalpha(static_cast<unsigned char>(fields[1][0])))
    throw InputError(path, line, "expected: element NAME COUNT");
  return {line, fields[1], *count, {}};
}

// What is not understood assimp passes over, and takes what follows for something else.
bool is_list_property(const std::vector<std::string_view>& fields, const std::filesystem::path& path,
                      int line) {
  static const std::set<std::string_view> kTypes{"char",  "uchar",  "short",   "ushort", "int",   "uint",
                                                 "float", "double", "int8",    "uint8",  "int16", "uint16",
                                                 "int32", "uint32", "float32", "float64"};
  const bool is_list = fields.size() == 5 && fields[1] == "list" && kTypes.contains(fields[3]);
  if (!(is_list || fields.size() == 3) || !kTypes.contains(fields[is_list ? 2 : 1]))
    throw InputError(path, line, "expected: property [list TYPE] TYPE NAME");
  return is_list;
}

Header read_header(std::string_view bytes, const std::filesystem::path& path) {
  Header header;
  for (int line = 1; bytes.find_first_of("\r\n", header.end) != bytes.npos; ++line) {
    const auto fields = next_line(bytes, header.end);
    header.lines = line;
    if (fields.empty()) continue;
    if (fields[0] == "end_header") return header;
    if (fields[0] == "element")
      header.elements.push_back(read_element(fields, path, line));
    else if (fields[0] == "property" && !header.elements.empty())
      header.elements.back().is_list.push_back(is_list_property(fields, path, line));
    else if (fields[0] == "format")
      header.ascii = fields.size() > 1 && fields[1] == "ascii";
    else if (line > 1 && fields[0] != "comment" && fields[0] != "obj_info")
      throw InputError(path, line, "expected: format, comment, obj_info, element, property or end_header");
  }
  throw InputError(path, "the header has no end_header");
}

std::size_t figures_of(const std::vector<bool>& is_list, const std::vector<std::string_view>& fields) {
  std::size_t count = 0;
  for (const bool list : is_list) {
    const auto members = list && count < fields.size() ? parse_integer(fields[count]) : 0;
    if (!members || *members < 0 || *members > static_cast<long long>(fields.size())) return 0;
    count += 1 + static_cast<std::size_t>(*members);
  }
  return count;
}

// A row a line. Assimp makes faces with indices from anywhere of what is none.
void check_rows(std::string_view bytes, const Header& header, const std::filesystem::path& path) {
  std::size_t at = header.end;
  int line = header.lines;
  for (const Element& element : header.elements)
    for (long long row = 0; row < element.count;) {
      if (at >= bytes.size())
        throw InputError(path, element.line, fmt::format("announces more {} than there are", element.name));
      const auto fields = next_line(bytes, at);
      ++line;
      if (fields.empty()) continue;
      ++row;
      if (fields.size() != figures_of(element.is_list, fields) ||
          !std::ranges::all_of(fields, [](std::string_view f) { return parse_double(f).has_value(); }))
        throw InputError(path, line, fmt::format("expected the figures of a row of {}", element.name));
    }
}

}  // namespace

void check_ply_header(std::string_view bytes, const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return std::tolower(c); });
  if (!is_ply(bytes) && extension == ".ply") throw InputError(path, 1, "does not begin with 'ply'");
  if (!is_ply(bytes)) return;
  const Header header = read_header(bytes, path);
  // The last line of a text need not end.
  auto left = static_cast<long long>(bytes.size() - header.end) + (header.ascii ? 1 : 0);
  const int least_bytes = header.ascii ? 2 : 1;
  for (const Element& element : header.elements) {
    if (element.count > left / least_bytes)
      throw InputError(
          path, element.line,
          fmt::format("announces {} {}, for which the file is too short", element.count, element.name));
    left -= element.count * least_bytes;
  }
  if (header.ascii) check_rows(bytes, header, path);
}

}  // namespace uniquadric
