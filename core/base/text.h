#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace uniquadric {

/// The whole of `text` as a finite number; nothing otherwise.
std::optional<double> parse_double(std::string_view text);
std::optional<long long> parse_integer(std::string_view text);

/// A YAML scalar that reads back as this text, whatever is in it: in double quotes.
std::string yaml_quoted(std::string_view text);

/// One line's last field of a CSV file with any text in it, and back: in double quotes where it has a comma
/// or a quote (RFC 4180), line ends as blanks. What is not in quotes is read as it is.
std::string csv_quoted(std::string text);
std::string csv_unquoted(std::string_view field);

/// Whether a text can be a name in CSV files and folders: not empty, no comma, quote, slash, backslash or
/// control character, UTF-8 of at most 200 bytes. At its beginning no dot, and none of = + - @, which make a
/// formula of a spreadsheet's cell.
bool is_plain_name(std::string_view text);
inline constexpr const char* kPlainNameExpected =
    "expected a name: not empty, no comma, quote, slash or control character, no = + - @ or dot first";

/// Fields of `line` between separators; with ' ' runs of blanks and tabs count as one.
std::vector<std::string_view> split(std::string_view line, char separator = ' ');

/// Calls `visit(line number from 1, fields)` for each line of a text file that is neither blank nor a comment
/// (#); a byte order mark of UTF-8 at the start is no part of the text. Throws InputError for a line of more
/// than 1 MiB, and for a byte order mark of UTF-16.
void for_each_line(const std::filesystem::path& path,
                   const std::function<void(int, const std::vector<std::string_view>&)>& visit,
                   char separator = ' ');

}  // namespace uniquadric
