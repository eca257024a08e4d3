#include "evaluation/metric_input.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "evaluation/strict_json_parts.h"

namespace uniquadric {
namespace {
using nlohmann::json;

constexpr int kMaxDepth = 8;  // ours: a line nests 3 deep; no stack is at risk up to here
// ours: ratios of squares of these stay far within a double, and no scene comes near them.
constexpr double kMinSemiAxis_m = 1e-9, kMaxSemiAxis_m = 1e12, kMaxPosition_m = 1e12;
constexpr double kMinFocal_px = 1e-6, kMaxFocal_px = 1e9, kMaxPrincipalPoint_px = 1e9;
constexpr double kMaxAxisRatio = 1e6;          // ours: a pair's whitened axes stay 1e12 apart, above rounding
constexpr double kQuaternionTolerance = 1e-3;  // SPEC 6: further off is an error
constexpr double kQuaternionKeepTolerance = 1e-12;  // rounding of a unit quaternion's own digits

// Replaces NaN, Infinity and -Infinity outside of strings.
std::string without_non_finite(const std::string& line) {
  std::string result;
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"' && (i == 0 || line[i - 1] != '\\')) quoted = !quoted;
    bool replaced = false;
    for (const std::string_view word : {"NaN", "-Infinity", "Infinity"}) {
      if (quoted || replaced || line.compare(i, word.size(), word) != 0) continue;
      result += "null";
      i += word.size() - 1;
      replaced = true;
    }
    if (!replaced) result += line[i];
  }
  return result;
}

json parse(const std::string& text) {
  try {
    try {
      return parse_strict_json(text, kMaxDepth);
    } catch (const JsonFault& e) {
      if (!e.is_syntax) throw;
      return parse_strict_json(without_non_finite(text), kMaxDepth);
    }
  } catch (const JsonFault& e) {
    throw InputError(e.what());
  }
}

const json& member(const json& object, const std::string& path, const char* key) {
  if (!object.is_object()) throw InputError(fmt::format("{}: expected an object", path));
  const auto found = object.find(key);
  if (found == object.end()) throw InputError(fmt::format("{}.{} is missing", path, key));
  return *found;
}

// What stands where a number is due: what it is, and a short one itself.
std::string shown(const json& value) {
  constexpr std::size_t kMostShown = 40;
  const std::string text = value.dump(-1, ' ', false, json::error_handler_t::replace);
  return text.size() > kMostShown ? std::string(value.type_name())
                                  : fmt::format("{} {}", value.type_name(), text);
}

std::string shortened(const std::string& text) {
  constexpr std::size_t kMostShown = 40;
  return text.size() > kMostShown ? text.substr(0, kMostShown) + "..." : text;
}

template <std::size_t N>
std::array<double, N> numbers(const json& object, const std::string& path, const char* key) {
  const json& list = member(object, path, key);
  const std::string name = fmt::format("{}.{}", path, key);
  if (!list.is_array() || list.size() != N) throw InputError(fmt::format("{}: expected {} numbers", name, N));
  std::array<double, N> values{};
  for (std::size_t i = 0; i < N; ++i) {
    // null is what NaN and Infinity were read as
    if (!list[i].is_number() && !list[i].is_null())
      throw InputError(fmt::format("{}[{}]: expected a number, found {}", name, i, shown(list[i])));
    if (list[i].is_null() || !std::isfinite(list[i].get<double>()))
      throw InputError(fmt::format("{}[{}] is not a finite number", name, i));
    values[i] = list[i].get<double>();
  }
  return values;
}

void expect_within(double value, double low, double high, const std::string& name) {
  if (!(value >= low && value <= high))
    throw InputError(fmt::format("{}: expected a number from {} to {}, found {}", name, low, high, value));
}

Eigen::Vector3d vector3(const json& object, const std::string& path, const char* key, double low,
                        double high) {
  const auto v = numbers<3>(object, path, key);
  for (std::size_t i = 0; i < 3; ++i) expect_within(v[i], low, high, fmt::format("{}.{}[{}]", path, key, i));
  return {v[0], v[1], v[2]};
}

Eigen::Vector3d position_m(const json& object, const std::string& path, const char* key) {
  return vector3(object, path, key, -kMaxPosition_m, kMaxPosition_m);
}

Eigen::Quaterniond unit_quaternion(const json& object, const std::string& path, const char* key) {
  const auto v = numbers<4>(object, path, key);
  Eigen::Quaterniond q(v[3], v[0], v[1], v[2]);
  const double off = std::abs(q.norm() - 1);
  if (!(off <= kQuaternionTolerance))
    throw InputError(fmt::format("{}.{}: quaternion has norm {}, not 1", path, key, q.norm()));
  if (off > kQuaternionKeepTolerance) q.normalize();
  return q;
}

void refuse_unknown(const json& object, const std::string& path, std::span<const std::string_view> known) {
  for (const auto& [key, value] : object.items())
    if (std::ranges::find(known, key) == known.end())
      throw InputError(fmt::format("{}key '{}' is unknown, expected {}", path.empty() ? "" : path + ": ",
                                   shortened(key), fmt::join(known, ", ")));
}

constexpr std::array<std::string_view, 4> kBodyKeys = {"a", "c", "q", "shape"};
constexpr std::array<std::string_view, 5> kCameraKeys = {"K", "height", "q_wc", "t_wc", "width"};

void read_exponents(const json& described, const std::string& path, Superellipsoid& body) {
  constexpr std::array<std::string_view, 2> kKeys = {"axis", "q"};
  refuse_unknown(described, path, std::array{std::string_view("superellipsoid")});
  const json& superellipsoid = member(described, path, "superellipsoid");
  const std::string name = path + ".superellipsoid";
  const auto q = numbers<3>(superellipsoid, name, "q");
  for (std::size_t i = 0; i < 3; ++i) expect_within(q[i], 1, 2, fmt::format("{}.q[{}]", name, i));
  refuse_unknown(superellipsoid, name, kKeys);
  body.exponents = {q[0], q[1], q[2]};
  const json axis = superellipsoid.value("axis", json("z"));
  if (axis != "x" && axis != "y" && axis != "z")
    throw InputError(fmt::format("{}.axis: expected x, y or z, found {}", name, shown(axis)));
  body.profile_axis = axis.get<std::string>()[0] - 'x';
}

void read_shape(const json& described, const std::string& path, Superellipsoid& body) {
  if (described.is_object()) return read_exponents(described, path, body);
  if (described != "box" && described != "ellipsoid")
    throw InputError(fmt::format("{}: expected ellipsoid, box or an object with superellipsoid, found {}",
                                 path, shown(described)));
  if (described == "box") body.exponents = kBoxExponents;
}

constexpr const char* kBlanks = " \t\r\n";

// The place of the quote that ends the string begun at `begin`, or of the line's last character.
std::size_t end_of_string(std::string_view line, std::size_t begin) {
  std::size_t i = begin + 1;
  while (i < line.size() && line[i] != '"') i += line[i] == '\\' ? 2 : 1;
  return std::min(i, line.size() - 1);
}

// The string or number at `begin`, "null" unless something stands behind it that says that it is whole.
std::string whole_scalar(std::string_view line, std::size_t begin) {
  if (begin == line.npos) return "null";
  const bool quoted = line[begin] == '"';
  const std::size_t end =
      quoted ? end_of_string(line, begin) + 1 : std::min(line.find_first_of(",}", begin), line.size());
  const std::size_t behind = line.find_first_not_of(kBlanks, end);
  if (behind == line.npos || (line[behind] != ',' && line[behind] != '}')) return "null";
  try {
    const json object = parse_strict_json(fmt::format("{{\"id\":{}}}", line.substr(begin, end - begin)), 1);
    const json& id = object.at("id");
    return id.is_string() || id.is_number() ? id.dump() : "null";
  } catch (const JsonFault&) {
    return "null";
  }
}

int image_side(const json& camera, const char* key) {
  constexpr double kMaxSide = 1e6;  // px: more is a mistake
  const json value = member(camera, "camera", key);
  if (!value.is_number() || value.get<double>() != std::floor(value.get<double>()) ||
      value.get<double>() < 1 || value.get<double>() > kMaxSide)
    throw InputError(fmt::format("camera.{}: expected a whole number of pixels", key));
  return static_cast<int>(value.get<double>());
}

}  // namespace

std::string stated_id_json(std::string_view line) {
  std::string id = "null";
  int depth = 0, found = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '{' || line[i] == '[') ++depth;
    if (line[i] == '}' || line[i] == ']') --depth;
    if (line[i] != '"') continue;
    const std::size_t begin = i;
    i = end_of_string(line, begin);
    if (depth != 1 || line.substr(begin, i + 1 - begin) != "\"id\"") continue;
    const std::size_t colon = line.find_first_not_of(kBlanks, i + 1);
    if (colon == line.npos || line[colon] != ':') continue;  // a value
    id = whole_scalar(line, line.find_first_not_of(kBlanks, colon + 1));
    ++found;
  }
  return found == 1 ? id : "null";
}

struct MetricLine::Json {
  json value;
};

MetricLine::MetricLine(const std::string& text) {
  json parsed = parse(text);
  if (!parsed.is_object()) throw InputError("expected a JSON object");
  json_ = std::make_shared<const Json>(Json{std::move(parsed)});
}

std::string MetricLine::id_json() const {
  const auto id = json_->value.find("id");
  if (id == json_->value.end()) return "null";
  if (!id->is_string() && !id->is_number() && !id->is_null())
    throw InputError("id: expected a string, a number or null");
  return id->dump();
}

void MetricLine::refuse_other_keys(std::span<const std::string_view> known) const {
  refuse_unknown(json_->value, "", known);
}

Ellipsoid MetricLine::ellipsoid(const char* key) const {
  const auto [body, world_from_body] = this->body(key);
  return {world_from_body, body.semi_axes_m};
}

PosedBody MetricLine::body(const char* key) const {
  const json& line = json_->value;
  const auto found = line.find(key);
  if (found == line.end()) throw InputError(fmt::format("{} is missing", key));
  PosedBody result;
  result.world_from_body = {unit_quaternion(*found, key, "q"), position_m(*found, key, "c")};
  Eigen::Vector3d& semi_axes_m = result.body.semi_axes_m;
  semi_axes_m = vector3(*found, key, "a", kMinSemiAxis_m, kMaxSemiAxis_m);
  if (semi_axes_m.maxCoeff() > kMaxAxisRatio * semi_axes_m.minCoeff())
    throw InputError(fmt::format("{}.a: the semi-axes are more than {} times apart", key, kMaxAxisRatio));
  refuse_unknown(*found, key, kBodyKeys);
  if (found->contains("shape")) read_shape(found->at("shape"), fmt::format("{}.shape", key), result.body);
  return result;
}

PosedCamera MetricLine::camera() const {
  const json& line = json_->value;
  const auto found = line.find("camera");
  if (found == line.end()) throw InputError("camera is missing");
  const auto K = numbers<9>(*found, "camera", "K");
  for (const std::size_t i : {0, 4})
    expect_within(K[i], kMinFocal_px, kMaxFocal_px, fmt::format("camera.K[{}]", i));
  for (const std::size_t i : {2, 5})
    expect_within(K[i], -kMaxPrincipalPoint_px, kMaxPrincipalPoint_px, fmt::format("camera.K[{}]", i));
  if (K[1] != 0 || K[3] != 0 || K[6] != 0 || K[7] != 0 || K[8] != 1)
    throw InputError("camera.K: expected fx 0 cx 0 fy cy 0 0 1");
  refuse_unknown(*found, "camera", kCameraKeys);
  PosedCamera result;
  result.camera.fx = K[0];
  result.camera.cx = K[2];
  result.camera.fy = K[4];
  result.camera.cy = K[5];
  result.camera.width = image_side(*found, "width");
  result.camera.height = image_side(*found, "height");
  result.world_from_camera = {unit_quaternion(*found, "camera", "q_wc"),
                              position_m(*found, "camera", "t_wc")};
  return result;
}

}  // namespace uniquadric
