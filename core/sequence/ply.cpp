#include "core/sequence/ply.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <string_view>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/text.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "values are written as they lie in memory");

template <typename T>
void put(std::string& data, T value) {
  data.append(reinterpret_cast<const char*>(&value), sizeof value);
}

struct Type {
  int size = 0;
  char kind = 'u';  // unsigned, i signed, f floating-point
};

std::optional<Type> type_of(std::string_view name) {
  static const std::map<std::string_view, Type> kTypes = {
      {"char", {1, 'i'}},  {"int8", {1, 'i'}},    {"uchar", {1, 'u'}},  {"uint8", {1, 'u'}},
      {"short", {2, 'i'}}, {"int16", {2, 'i'}},   {"ushort", {2, 'u'}}, {"uint16", {2, 'u'}},
      {"int", {4, 'i'}},   {"int32", {4, 'i'}},   {"uint", {4, 'u'}},   {"uint32", {4, 'u'}},
      {"float", {4, 'f'}}, {"float32", {4, 'f'}}, {"double", {8, 'f'}}, {"float64", {8, 'f'}}};
  const auto found = kTypes.find(name);
  return found == kTypes.end() ? std::nullopt : std::optional(found->second);
}

struct Property {
  std::string name;
  Type type, count;  // count: of a list's values, size 0 where it is none
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  std::vector<Element> elements;
  std::size_t end = 0;  // where the data begin
};

class HeaderReader {
 public:
  HeaderReader(const fs::path& path, std::string_view text) : path_(path), text_(text) {}

  Header read() {
    if (next() != std::vector<std::string_view>{"ply"}) fail("expected ply");
    bool has_format = false;
    for (;;) {
      const auto words = next();
      if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
      if (words[0] == "end_header") break;
      if (words[0] == "format")
        has_format = take_format(words);
      else if (words[0] == "element")
        take_element(words);
      else if (words[0] == "property")
        take_property(words);
      else
        fail(fmt::format("'{}' is no entry of a PLY header", words[0].substr(0, 20)));
    }
    if (!has_format) fail("the header has no format");
    return header_;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw InputError(path_, line_, what); }

  std::vector<std::string_view> next() {
    const std::size_t stop = text_.find('\n', header_.end);
    ++line_;
    if (stop == std::string_view::npos) fail("the header does not end");
    std::string_view line = text_.substr(header_.end, stop - header_.end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    header_.end = stop + 1;
    return split(line);
  }
  bool take_format(const std::vector<std::string_view>& words) const {
    if (words.size() != 3 || words[1] != "binary_little_endian")
      fail("only the format binary_little_endian is read");
    return true;
  }
  void take_element(const std::vector<std::string_view>& words) {
    const auto count = words.size() == 3 ? parse_integer(words[2]) : std::nullopt;
    if (!count || *count < 0) fail("expected element NAME COUNT");
    header_.elements.push_back({std::string(words[1]), static_cast<std::uint64_t>(*count), {}});
  }
  void take_property(const std::vector<std::string_view>& words) {
    const bool is_list = words.size() == 5 && words[1] == "list";
    if (header_.elements.empty() || (!is_list && words.size() != 3))
      fail("expected property TYPE NAME, or property list TYPE TYPE NAME, of an element");
    const auto type = type_of(words[words.size() - 2]);
    const auto count = is_list ? type_of(words[2]) : Type{};
    if (!type || !count || count->kind == 'f') fail("a property of an unknown type");
    header_.elements.back().properties.push_back({std::string(words.back()), *type, *count});
  }

  const fs::path& path_;
  std::string_view text_;
  Header header_;
  int line_ = 0;
};

class DataReader {
 public:
  DataReader(const fs::path& path, std::string_view data) : path_(path), data_(data) {}

  double number(const Type& type) {
    const char* at = take(type.size);
    switch (type.size) {
      case 1:
        return type.kind == 'i' ? as<std::int8_t>(at) : as<std::uint8_t>(at);
      case 2:
        return type.kind == 'i' ? as<std::int16_t>(at) : as<std::uint16_t>(at);
      case 4:
        return type.kind == 'f'   ? as<float>(at)
               : type.kind == 'i' ? as<std::int32_t>(at)
                                  : as<std::uint32_t>(at);
      default:
        return as<double>(at);
    }
  }
  std::vector<double> numbers(const Property& property) {
    const double count = property.count.size == 0 ? 1 : number(property.count);
    if (count < 0 || count * property.type.size > static_cast<double>(data_.size() - at_)) cut_short();
    std::vector<double> values;
    for (int i = 0; i < static_cast<int>(count); ++i) values.push_back(number(property.type));
    return values;
  }

  std::size_t left() const { return data_.size() - at_; }

 private:
  template <typename T>
  static double as(const char* at) {
    T value;
    std::memcpy(&value, at, sizeof value);
    return static_cast<double>(value);
  }
  [[noreturn]] void cut_short() const { throw InputError(path_, "its data are cut short"); }
  const char* take(int size) {
    if (data_.size() - at_ < static_cast<std::size_t>(size)) cut_short();
    at_ += static_cast<std::size_t>(size);
    return data_.data() + at_ - size;
  }

  const fs::path& path_;
  std::string_view data_;
  std::size_t at_ = 0;
};

std::optional<Eigen::Vector3f> vector_of(const std::map<std::string, double>& values,
                                         const std::array<const char*, 3>& names) {
  Eigen::Vector3f v;
  for (int k = 0; k < 3; ++k) {
    const auto found = values.find(names[k]);
    if (found == values.end()) return std::nullopt;
    v[k] = static_cast<float>(found->second);
  }
  return v;
}

void read_point(const fs::path& path, const Element& element, DataReader& data, SurfaceFile& surface) {
  std::map<std::string, double> values;
  for (const Property& property : element.properties)
    if (const auto numbers = data.numbers(property); property.count.size == 0)
      values[property.name] = numbers[0];
  const auto point = vector_of(values, {"x", "y", "z"});
  if (!point) throw InputError(path, "its vertices have no x, y, z");
  if (!point->allFinite() || point->cwiseAbs().maxCoeff() > kMostPlyCoordinate_m)
    throw InputError(path, fmt::format("point {} is not finite, or lies beyond {} m", surface.points.size(),
                                       kMostPlyCoordinate_m));
  surface.points.push_back(*point);
  if (const auto normal = vector_of(values, {"nx", "ny", "nz"})) surface.normals.push_back(*normal);
}

void read_face(const fs::path& path, const Element& element, DataReader& data, SurfaceFile& surface) {
  for (const Property& property : element.properties) {
    const std::vector<double> corners = data.numbers(property);
    if (property.name != "vertex_indices" && property.name != "vertex_index") continue;
    for (const double corner : corners)
      if (!(corner >= 0 && corner < static_cast<double>(surface.points.size())))
        throw InputError(path, fmt::format("a face has point {} of {}", corner, surface.points.size()));
    for (std::size_t i = 2; i < corners.size(); ++i)
      surface.triangles.push_back({static_cast<std::uint32_t>(corners[0]),
                                   static_cast<std::uint32_t>(corners[i - 1]),
                                   static_cast<std::uint32_t>(corners[i])});
  }
}

}  // namespace

void write_ply(const fs::path& path, const std::string& comment, const std::string& elements,
               const std::string& data) {
  write_text(path, fmt::format("ply\nformat binary_little_endian 1.0\ncomment {}\n{}end_header\n", comment,
                               elements) +
                       data);
}

void write_surface_ply(const fs::path& path, const SurfaceFile& surface, const std::string& comment) {
  const bool has_normals = !surface.normals.empty();
  std::string elements = fmt::format(
      "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n", surface.points.size());
  if (has_normals) elements += "property float nx\nproperty float ny\nproperty float nz\n";
  if (!surface.triangles.empty())
    elements +=
        fmt::format("element face {}\nproperty list uchar int vertex_indices\n", surface.triangles.size());
  std::string data;
  for (std::size_t i = 0; i < surface.points.size(); ++i) {
    for (int k = 0; k < 3; ++k) put(data, surface.points[i][k]);
    for (int k = 0; has_normals && k < 3; ++k) put(data, surface.normals[i][k]);
  }
  for (const auto& triangle : surface.triangles) {
    put(data, std::uint8_t{3});
    for (const std::uint32_t corner : triangle) put(data, static_cast<std::int32_t>(corner));
  }
  write_ply(path, comment, elements, data);
}

SurfaceFile read_surface_ply(const fs::path& path) {
  const std::string text = read_text(path);
  const Header header = HeaderReader(path, text).read();
  DataReader data(path, std::string_view(text).substr(header.end));
  SurfaceFile surface;
  for (const Element& element : header.elements) {
    if (element.properties.empty())
      throw InputError(path, fmt::format("{}: without properties", element.name));
    for (std::uint64_t i = 0; i < element.count; ++i) {
      if (element.name == "vertex")
        read_point(path, element, data, surface);
      else if (element.name == "face")
        read_face(path, element, data, surface);
      else
        for (const Property& property : element.properties) data.numbers(property);
    }
  }
  if (data.left() > 0) throw InputError(path, fmt::format("{} bytes after its data", data.left()));
  if (surface.points.empty()) throw InputError(path, "has no points");
  return surface;
}

}  // namespace uniquadric
