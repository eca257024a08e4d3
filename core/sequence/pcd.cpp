#include "core/sequence/pcd.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <string_view>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/read_file.h"
#include "core/base/text.h"

namespace uniquadric {
namespace {

static_assert(std::endian::native == std::endian::little,
              "PCD's binary data are written as they lie in memory");

const std::vector<std::string> kHeaderKeys = {"VERSION", "FIELDS", "SIZE",      "TYPE",   "COUNT",
                                              "WIDTH",   "HEIGHT", "VIEWPOINT", "POINTS", "DATA"};
constexpr std::int64_t kMaxPoints = 1'000'000'000;
constexpr std::int64_t kMaxPointBytes = 1 << 16;  // ours: no sensor's are a hundredth

struct HeaderLine {
  int line = 0;
  std::vector<std::string_view> values;
};

struct Header {
  const std::filesystem::path& path;
  std::map<std::string, HeaderLine, std::less<>> lines;
  std::size_t end = 0;  // where the data begin

  [[noreturn]] void fail(const std::string& key, const std::string& what) const {
    throw InputError(path, lines.at(key).line, key + ": " + what);
  }
  std::int64_t number(const std::string& key, std::size_t i = 0) const {
    const auto& values = lines.at(key).values;
    const auto value = i < values.size() ? parse_integer(values[i]) : std::nullopt;
    if (!value || *value < 0) fail(key, "expected a count");
    if (*value > kMaxPoints)
      fail(key, fmt::format("{} is more than {}, the most that is read", *value, kMaxPoints));
    return *value;
  }
};

Header read_header(const std::filesystem::path& path, std::string_view text) {
  Header header{path, {}, 0};
  for (int line = 1; header.end < text.size(); ++line) {
    const std::size_t stop = text.find('\n', header.end);
    if (stop == std::string_view::npos) break;
    auto values = split(text.substr(header.end, stop - header.end));
    header.end = stop + 1;
    if (values.empty() || values[0].starts_with('#')) continue;
    const std::string key(values[0]);
    if (std::find(kHeaderKeys.begin(), kHeaderKeys.end(), key) == kHeaderKeys.end())
      throw InputError(path, line, fmt::format("'{}' is no entry of a PCD header", key.substr(0, 20)));
    values.erase(values.begin());
    if (!header.lines.try_emplace(key, HeaderLine{line, values}).second)
      throw InputError(path, line, fmt::format("{} stands twice", key));
    if (key == "DATA") break;
  }
  for (const std::string& key : kHeaderKeys)
    if (!header.lines.contains(key) && key != "VIEWPOINT" && key != "COUNT")
      throw InputError(path, fmt::format("the header has no {}", key));
  return header;
}

std::vector<PcdField> read_fields(const Header& header) {
  const auto& names = header.lines.at("FIELDS").values;
  if (names.empty()) header.fail("FIELDS", "names no field");
  for (const char* key : {"SIZE", "TYPE", "COUNT"})
    if (header.lines.contains(key) && header.lines.at(key).values.size() != names.size())
      header.fail(key,
                  fmt::format("{} values for {} fields", header.lines.at(key).values.size(), names.size()));
  std::vector<PcdField> fields;
  std::set<std::string> known;
  std::int64_t bytes = 0;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string_view type = header.lines.at("TYPE").values[i];
    const std::int64_t size = header.number("SIZE", i);
    if (type != "F" && type != "I" && type != "U")
      header.fail("TYPE", fmt::format("'{}' is none of F, I, U", type));
    if (size != 1 && size != 2 && size != 4 && size != 8)
      header.fail("SIZE", fmt::format("a value of {} bytes", size));
    if (type == "F" && size < 4) header.fail("SIZE", fmt::format("a floating-point value of {} bytes", size));
    const std::int64_t count = header.lines.contains("COUNT") ? header.number("COUNT", i) : 1;
    PcdField field{std::string(names[i]), static_cast<int>(size), type[0]};
    if (count != 1 && !field.is_padding())
      header.fail("COUNT",
                  fmt::format("field {} has {}", names[i], count == 0 ? "no value" : "more than one value"));
    bytes += size * count;
    if (bytes > kMaxPointBytes)
      header.fail("COUNT",
                  fmt::format("a point has more than {} bytes, the most that is read", kMaxPointBytes));
    field.count = static_cast<int>(count);
    if (!field.is_padding() && !known.insert(field.name).second)
      header.fail("FIELDS", fmt::format("{} stands twice", field.name.substr(0, 20)));
    fields.push_back(field);
  }
  return fields;
}

Pose read_viewpoint(const Header& header) {
  if (!header.lines.contains("VIEWPOINT")) return {};
  std::vector<double> v;
  for (const auto& text : header.lines.at("VIEWPOINT").values)
    if (const auto value = parse_double(text)) v.push_back(*value);
  if (v.size() != 7 || header.lines.at("VIEWPOINT").values.size() != 7)
    header.fail("VIEWPOINT", "expected 7 numbers");
  const Pose pose{{v[3], v[4], v[5], v[6]}, {v[0], v[1], v[2]}};
  constexpr double kUnitTolerance = 1e-3;  // of a quaternion's norm, as for trajectories that are read
  if (std::abs(pose.rotation.norm() - 1) > kUnitTolerance)
    header.fail("VIEWPOINT", "the quaternion is not of length 1");
  return pose;
}

// PCL maps its files into memory and leaves zeros behind the points, up to a whole page.
void trim_data(const std::filesystem::path& path, PcdFile& file) {
  const auto bytes = static_cast<std::size_t>(file.points * file.point_size());
  if (file.data.size() < bytes)
    throw InputError(path, fmt::format("{} bytes of data, {} points of {} bytes are {}", file.data.size(),
                                       file.points, file.point_size(), bytes));
  if (file.data.find_first_not_of('\0', bytes) != std::string::npos)
    throw InputError(path,
                     fmt::format("{} bytes of data, {} points of {} bytes are {}: zeros alone may follow",
                                 file.data.size(), file.points, file.point_size(), bytes));
  file.data.resize(bytes);
}

}  // namespace

int PcdFile::point_size() const {
  return std::accumulate(fields.begin(), fields.end(), 0,
                         [](int sum, const PcdField& f) { return sum + f.size * f.count; });
}

void write_pcd(const std::filesystem::path& path, const PcdFile& file) {
  std::string names, sizes, types, counts;
  for (const PcdField& field : file.fields) {
    names += ' ' + field.name;
    sizes += fmt::format(" {}", field.size);
    types += fmt::format(" {}", field.type);
    counts += fmt::format(" {}", field.count);
  }
  const Eigen::Vector3d& t = file.viewpoint.translation;
  const Eigen::Quaterniond& q = file.viewpoint.rotation;
  write_text(
      path,
      fmt::format("# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS{}\nSIZE{}\nTYPE{}\n"
                  "COUNT{}\nWIDTH {}\nHEIGHT 1\nVIEWPOINT {} {} {} {} {} {} {}\nPOINTS {}\nDATA binary\n",
                  names, sizes, types, counts, file.points, t.x(), t.y(), t.z(), q.w(), q.x(), q.y(), q.z(),
                  file.points) +
          file.data);
}

PcdFile read_pcd(const std::filesystem::path& path) {
  const std::string text = read_file(path, kPointFile);
  const Header header = read_header(path, text);
  const auto& version = header.lines.at("VERSION").values;
  if (version.size() != 1 || (version[0] != "0.7" && version[0] != ".7"))
    header.fail("VERSION", "expected 0.7");
  const auto& kind = header.lines.at("DATA").values;
  if (kind.size() != 1 || kind[0] != "binary") header.fail("DATA", "only binary data are read");
  PcdFile file{read_fields(header), header.number("POINTS"), read_viewpoint(header), text.substr(header.end)};
  const std::int64_t width = header.number("WIDTH"), height = header.number("HEIGHT");
  if (width * height != file.points)
    header.fail("POINTS", fmt::format("{}, but WIDTH {} times HEIGHT {} is {}", file.points, width, height,
                                      width * height));
  trim_data(path, file);
  return file;
}

PcdColumn pcd_column(const std::filesystem::path& path, const PcdFile& file, std::string_view name, char type,
                     int size) {
  std::size_t offset = 0;
  for (const PcdField& field : file.fields) {
    if (field.name == name) {
      if (field.type != type || field.size != size)
        throw InputError(
            path, fmt::format("field {} is {}{}, expected {}{}", name, field.type, field.size, type, size));
      return {file, offset};
    }
    offset += static_cast<std::size_t>(field.size * field.count);
  }
  throw InputError(path, fmt::format("has no field {}", name));
}

}  // namespace uniquadric
