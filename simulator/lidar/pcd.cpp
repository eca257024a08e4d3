#include "simulator/lidar/pcd.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <map>
#include <numeric>
#include <string_view>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/text.h"

namespace uniquadric {
namespace {

static_assert(std::endian::native == std::endian::little,
              "PCD's binary data are written as they lie in memory");

const std::vector<std::string> kHeaderKeys = {"VERSION", "FIELDS", "SIZE",      "TYPE",   "COUNT",
                                              "WIDTH",   "HEIGHT", "VIEWPOINT", "POINTS", "DATA"};
constexpr std::int64_t kMaxPoints = 1'000'000'000;

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
    if (!value || *value < 0 || *value > kMaxPoints) fail(key, "expected a count");
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
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string_view type = header.lines.at("TYPE").values[i];
    const std::int64_t size = header.number("SIZE", i);
    if (type != "F" && type != "I" && type != "U")
      header.fail("TYPE", fmt::format("'{}' is none of F, I, U", type));
    if (size != 1 && size != 2 && size != 4 && size != 8)
      header.fail("SIZE", fmt::format("a value of {} bytes", size));
    if (type == "F" && size < 4) header.fail("SIZE", fmt::format("a floating-point value of {} bytes", size));
    if (header.lines.contains("COUNT") && header.number("COUNT", i) != 1)
      header.fail("COUNT", fmt::format("field {} has more than one value", names[i]));
    fields.push_back({std::string(names[i]), static_cast<int>(size), type[0]});
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

template <typename T>
void put(std::string& data, T value) {
  data.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// Where a field lies in a point.
struct Column {
  const PcdFile& file;
  std::size_t offset = 0;

  template <typename T>
  T at(std::int64_t point) const {
    T value;
    std::copy_n(file.data.data() + static_cast<std::size_t>(point * file.point_size()) + offset, sizeof value,
                reinterpret_cast<char*>(&value));
    return value;
  }
};

Column column(const std::filesystem::path& path, const PcdFile& file, std::string_view name, char type,
              int size) {
  std::size_t offset = 0;
  for (const PcdField& field : file.fields) {
    if (field.name == name) {
      if (field.type != type || field.size != size)
        throw InputError(
            path, fmt::format("field {} is {}{}, expected {}{}", name, field.type, field.size, type, size));
      return {file, offset};
    }
    offset += static_cast<std::size_t>(field.size);
  }
  throw InputError(path, fmt::format("has no field {}", name));
}

}  // namespace

int PcdFile::point_size() const {
  return std::accumulate(fields.begin(), fields.end(), 0,
                         [](int sum, const PcdField& f) { return sum + f.size; });
}

void write_pcd(const std::filesystem::path& path, const PcdFile& file) {
  std::string names, sizes, types, counts;
  for (const PcdField& field : file.fields) {
    names += ' ' + field.name;
    sizes += fmt::format(" {}", field.size);
    types += fmt::format(" {}", field.type);
    counts += " 1";
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
  const std::string text = read_text(path);
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
  const std::int64_t bytes = file.points * file.point_size();
  if (static_cast<std::int64_t>(file.data.size()) != bytes)
    throw InputError(path, fmt::format("{} bytes of data, {} points of {} bytes are {}", file.data.size(),
                                       file.points, file.point_size(), bytes));
  return file;
}

PcdFile points_pcd(const LidarScan& scan) {
  PcdFile file;
  file.fields = {{"x"},
                 {"y"},
                 {"z"},
                 {"intensity"},
                 {"offset_time", 4, 'U'},
                 {"t", 4, 'U'},
                 {"time"},
                 {"ring", 2, 'U'},
                 {"tag", 1, 'U'}};
  file.points = static_cast<std::int64_t>(scan.points.size());
  file.data.reserve(scan.points.size() * static_cast<std::size_t>(file.point_size()));
  for (const LidarPoint& p : scan.points) {
    for (const float value : {p.x, p.y, p.z, p.intensity}) put(file.data, value);
    put(file.data, p.offset_ns);
    put(file.data, p.offset_ns);
    put(file.data, static_cast<float>(p.offset_ns * 1e-9));
    put(file.data, p.ring);
    put(file.data, p.tag);
  }
  return file;
}

PcdFile truth_pcd(const LidarScan& scan, const Pose& world_from_lidar) {
  PcdFile file;
  file.fields = {{"range"}, {"incidence_cos"}, {"instance", 2, 'U'}, {"kind", 1, 'U'}};
  file.points = static_cast<std::int64_t>(scan.truth.size());
  file.viewpoint = world_from_lidar;
  for (const LidarPointTruth& t : scan.truth) {
    put(file.data, t.range_m);
    put(file.data, t.incidence_cos);
    put(file.data, t.instance);
    put(file.data, static_cast<std::uint8_t>(t.kind));
  }
  return file;
}

std::vector<LidarPoint> read_points(const std::filesystem::path& path) {
  const PcdFile file = read_pcd(path);
  const Column x = column(path, file, "x", 'F', 4), y = column(path, file, "y", 'F', 4),
               z = column(path, file, "z", 'F', 4), intensity = column(path, file, "intensity", 'F', 4),
               t = column(path, file, "t", 'U', 4), ring = column(path, file, "ring", 'U', 2),
               tag = column(path, file, "tag", 'U', 1);
  std::vector<LidarPoint> points;
  for (std::int64_t i = 0; i < file.points; ++i)
    points.push_back({x.at<float>(i), y.at<float>(i), z.at<float>(i), intensity.at<float>(i),
                      t.at<std::uint32_t>(i), ring.at<std::uint16_t>(i), tag.at<std::uint8_t>(i)});
  return points;
}

std::vector<LidarPointTruth> read_point_truth(const std::filesystem::path& path) {
  const PcdFile file = read_pcd(path);
  const Column range = column(path, file, "range", 'F', 4),
               cosine = column(path, file, "incidence_cos", 'F', 4),
               instance = column(path, file, "instance", 'U', 2), kind = column(path, file, "kind", 'U', 1);
  std::vector<LidarPointTruth> truth;
  for (std::int64_t i = 0; i < file.points; ++i) {
    const auto what = kind.at<std::uint8_t>(i);
    if (what > static_cast<std::uint8_t>(LidarPointTruth::Kind::false_alarm))
      throw InputError(path, fmt::format("point {}: kind {} is none of 0, 1, 2", i, what));
    truth.push_back({range.at<float>(i), cosine.at<float>(i), instance.at<std::uint16_t>(i),
                     static_cast<LidarPointTruth::Kind>(what)});
  }
  return truth;
}

}  // namespace uniquadric
