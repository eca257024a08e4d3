#include "core/sequence/ply_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>

#include "core/base/error.h"
#include "core/base/text.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "bytes are turned round for the other order");

constexpr std::string_view kLineEnds = "\r\n", kBlanks = " \t";

std::optional<PlyType> type_of(std::string_view name) {
  static const std::map<std::string_view, PlyType> kTypes = {
      {"char", {1, 'i'}},  {"int8", {1, 'i'}},    {"uchar", {1, 'u'}},  {"uint8", {1, 'u'}},
      {"short", {2, 'i'}}, {"int16", {2, 'i'}},   {"ushort", {2, 'u'}}, {"uint16", {2, 'u'}},
      {"int", {4, 'i'}},   {"int32", {4, 'i'}},   {"uint", {4, 'u'}},   {"uint32", {4, 'u'}},
      {"float", {4, 'f'}}, {"float32", {4, 'f'}}, {"double", {8, 'f'}}, {"float64", {8, 'f'}}};
  const auto found = kTypes.find(name);
  return found == kTypes.end() ? std::nullopt : std::optional(found->second);
}

std::string_view line_of(std::string_view text) {
  return text.substr(0, text.find_first_of(kLineEnds));
}

void drop_line(std::string_view& text) {
  text.remove_prefix(line_of(text).size());
  text.remove_prefix(text.starts_with("\r\n") ? 2 : std::min<std::size_t>(text.size(), 1));
}

bool is_blank(std::string_view text) {
  return text.find_first_not_of(kBlanks) == text.npos;
}

// A figure and a blank or line end each in text.
std::uint64_t least_bytes(PlyFormat format, const PlyElement& element) {
  std::uint64_t bytes = 0;
  for (const auto& [name, type, count] : element.properties)
    bytes += static_cast<std::uint64_t>(format == PlyFormat::ascii ? 2
                                        : count.size > 0           ? count.size
                                                                   : type.size);
  return bytes;
}

class HeaderReader {
 public:
  HeaderReader(const fs::path& path, std::string_view bytes) : path_(path), left_(bytes) {}

  PlyHeader read() {
    const std::size_t size = left_.size();
    if (next() != std::vector<std::string_view>{"ply"}) fail("expected ply");
    for (;;) {
      const auto words = next();
      if (words.empty() || words[0] == "obj_info") continue;
      if (words[0] == "end_header") break;
      if (words[0] == "comment")
        take_comment(words);
      else if (words[0] == "format")
        take_format(words);
      else if (words[0] == "element")
        take_element(words);
      else if (words[0] == "property")
        take_property(words);
      else
        fail(fmt::format("'{}' is no entry of a PLY header", words[0].substr(0, 20)));
    }
    if (!has_format_) fail("the header has no format");
    header_.end = size - left_.size();
    check_counts();
    return header_;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw InputError(path_, header_.lines, what); }

  std::vector<std::string_view> next() {
    const std::string_view line = line_of(left_);
    ++header_.lines;
    if (line.size() == left_.size()) fail("the header does not end");
    drop_line(left_);
    return split(line);
  }
  void take_comment(const std::vector<std::string_view>& words) {
    if (words.size() > 2 && words[1] == "TextureFile")  // with the blanks in its name
      header_.texture_file.assign(words[2].data(), words.back().data() + words.back().size());
  }
  void take_format(const std::vector<std::string_view>& words) {
    static const std::map<std::string_view, PlyFormat> kFormats = {
        {"ascii", PlyFormat::ascii},
        {"binary_little_endian", PlyFormat::binary_little_endian},
        {"binary_big_endian", PlyFormat::binary_big_endian}};
    const auto found = words.size() == 3 ? kFormats.find(words[1]) : kFormats.end();
    if (found == kFormats.end())
      fail("expected format ascii, binary_little_endian or binary_big_endian, 1.0");
    header_.format = found->second;
    has_format_ = true;
  }
  void take_element(const std::vector<std::string_view>& words) {
    const auto count = words.size() == 3 ? parse_integer(words[2]) : std::nullopt;
    if (!count || *count < 0) fail("expected element NAME COUNT");
    for (const PlyElement& other : header_.elements)
      if (other.name == words[1]) fail(fmt::format("element {} stands on line {}", other.name, other.line));
    header_.elements.push_back({std::string(words[1]), static_cast<std::uint64_t>(*count), header_.lines});
  }
  void take_property(const std::vector<std::string_view>& words) {
    const bool is_list = words.size() == 5 && words[1] == "list";
    if (header_.elements.empty() || (!is_list && words.size() != 3))
      fail("expected property TYPE NAME, or property list TYPE TYPE NAME, of an element");
    const auto type = type_of(words[words.size() - 2]);
    const auto count = is_list ? type_of(words[2]) : PlyType{};
    if (!type || !count || count->kind == 'f') fail("a property of an unknown type");
    header_.elements.back().properties.push_back({std::string(words.back()), *type, *count});
  }
  void check_counts() const {
    // The last line of a text need not end.
    std::uint64_t left = left_.size() + (header_.format == PlyFormat::ascii ? 1 : 0);
    for (const PlyElement& element : header_.elements) {
      const std::uint64_t bytes = least_bytes(header_.format, element);
      if (bytes == 0)
        throw InputError(path_, element.line, fmt::format("{} has no properties", element.name));
      if (element.count > left / bytes)
        throw InputError(
            path_, element.line,
            fmt::format("announces {} {}, for which the file is too short", element.count, element.name));
      left -= element.count * bytes;
    }
  }

  const fs::path& path_;
  std::string_view left_;
  PlyHeader header_;
  bool has_format_ = false;
};

template <typename T>
double as(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return static_cast<double>(value);
}

double number_of(const char* bytes, const PlyType& type) {
  switch (type.size) {
    case 1:
      return type.kind == 'i' ? as<std::int8_t>(bytes) : as<std::uint8_t>(bytes);
    case 2:
      return type.kind == 'i' ? as<std::int16_t>(bytes) : as<std::uint16_t>(bytes);
    case 4:
      return type.kind == 'f'   ? as<float>(bytes)
             : type.kind == 'i' ? as<std::int32_t>(bytes)
                                : as<std::uint32_t>(bytes);
    default:
      return as<double>(bytes);
  }
}

}  // namespace

PlyHeader read_ply_header(const fs::path& path, std::string_view bytes) {
  return HeaderReader(path, bytes).read();
}

PlyRows::PlyRows(const fs::path& path, std::string_view bytes, const PlyHeader& header)
    : path_(path), left_(bytes.substr(header.end)), format_(header.format), line_(header.lines) {}

void PlyRows::fail(const std::string& what) const {
  const std::string row = fmt::format("{} {}: {}", element_->name, row_, what);
  if (format_ == PlyFormat::ascii) throw InputError(path_, line_, row);
  throw InputError(path_, row);
}

const std::vector<std::vector<double>>& PlyRows::next(const PlyElement& element) {
  begin_row(element);
  values_.resize(element.properties.size());
  for (std::size_t i = 0; i < values_.size(); ++i) {
    const auto& [name, type, list] = element.properties[i];
    const double count = list.size == 0 ? 1 : number(list);
    if (!(count >= 0) || count != std::floor(count)) fail(fmt::format("{} has {} values", name, count));
    const double least_bytes = count * (format_ == PlyFormat::ascii ? 1 : type.size);
    if (least_bytes > static_cast<double>(left_.size())) fail("is cut short");
    values_[i].resize(static_cast<std::size_t>(count));
    for (double& value : values_[i]) value = number(type);
  }
  if (format_ != PlyFormat::ascii) return values_;
  if (!is_blank(line_of(left_))) fail("has more numbers than its properties");
  drop_line(left_);
  return values_;
}

void PlyRows::begin_row(const PlyElement& element) {
  row_ = element_ == &element ? row_ + 1 : 0;
  element_ = &element;
  if (format_ != PlyFormat::ascii) return;
  for (++line_; !left_.empty() && is_blank(line_of(left_)); ++line_) drop_line(left_);
  if (left_.empty())
    throw InputError(
        path_, element.line,
        fmt::format("announces {} {}, of which there are {}", element.count, element.name, row_));
}

double PlyRows::number(const PlyType& type) {
  if (format_ == PlyFormat::ascii) return word();
  const auto size = static_cast<std::size_t>(type.size);
  if (left_.size() < size) fail("is cut short");
  char bytes[8] = {};
  std::copy_n(left_.data(), size, bytes);
  if (format_ == PlyFormat::binary_big_endian) std::reverse(bytes, bytes + size);
  left_.remove_prefix(size);
  return number_of(bytes, type);
}

double PlyRows::word() {
  left_.remove_prefix(std::min(left_.find_first_not_of(kBlanks), left_.size()));
  const std::string_view word = left_.substr(0, left_.find_first_of(" \t\r\n"));
  left_.remove_prefix(word.size());
  const auto value = parse_double(word);
  if (!value)
    fail(word.empty() ? "has fewer numbers than its properties"
                      : fmt::format("expected a number, found '{}'", word.substr(0, 20)));
  return *value;
}

void PlyRows::expect_end() {
  if (format_ == PlyFormat::ascii)
    for (++line_; !left_.empty() && is_blank(line_of(left_)); ++line_) drop_line(left_);
  if (left_.empty()) return;
  const std::string what = fmt::format("{} bytes after the last row", left_.size());
  if (format_ == PlyFormat::ascii) throw InputError(path_, line_, what);
  throw InputError(path_, what);
}

}  // namespace uniquadric
