#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/text.h"
#include "evaluation/results/metrics.h"
#include "evaluation/results/results.h"
#include "evaluation/results/series.h"
#include "evaluation/run_record.h"
#include "evaluation/strict_json_parts.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kEvaluationSchema = 1;

[[noreturn]] void fail(const fs::path& file, const std::string& field, const std::string& what) {
  throw InputError(file, fmt::format("field {}: {}", field, what));
}

// "/objects/1/ape" -> "objects[1].ape"
std::string field_name(const std::string& pointer) {
  std::string name;
  for (const auto part : split(std::string_view(pointer).substr(1), '/'))
    name +=
        parse_integer(part) ? fmt::format("[{}]", part) : fmt::format("{}{}", name.empty() ? "" : ".", part);
  return name;
}

// The number at a pointer; nothing when it, or what it stands in, is absent or null.
std::optional<double> number_at(const fs::path& file, const json& root, const std::string& pointer) {
  const json* node = &root;
  std::string walked;
  for (const auto part : split(std::string_view(pointer).substr(1), '/')) {
    if (!node->is_object() && !node->is_array())
      fail(file, field_name(walked), "expected an object with named values");
    if (node->is_array()) {
      const auto index = parse_integer(part);
      if (!index) fail(file, field_name(walked), "expected an object with named values");
      node = &node->at(static_cast<std::size_t>(*index));
    } else {
      const auto found = node->find(part);
      if (found == node->end() || found->is_null()) return std::nullopt;
      node = &*found;
    }
    walked += fmt::format("/{}", part);
  }
  if (!node->is_number()) fail(file, field_name(pointer), "expected a number");
  return node->get<double>();
}

SubjectFigures read_figures(const fs::path& file, const json& root, const std::string& base,
                            const std::string& subject, MetricScope scope) {
  SubjectFigures figures{subject, {}};
  for (const Metric& metric : all_metrics())
    if (metric.scopes & static_cast<int>(scope))
      if (const auto value = number_at(file, root, base + metric.pointer)) {
        if (const auto why = impossible(metric, *value)) fail(file, field_name(base + metric.pointer), *why);
        figures.value[metric.name] = *value;
      }
  return figures;
}

// Lower-case names as in scores.csv; objects without a name, or with one that stands twice, by their id.
std::vector<NamedObject> read_names(const fs::path& file, const json& root) {
  const auto objects = root.find("objects");
  if (objects == root.end() || !objects->is_array()) fail(file, "objects", "expected a list");
  std::vector<NamedObject> named;
  for (std::size_t i = 0; i < objects->size(); ++i) {
    const json& object = (*objects)[i];
    const std::string field = fmt::format("objects[{}]", i);
    if (!object.is_object()) fail(file, field, "expected an object with named values");
    if (!object.contains("id") || !object["id"].is_number_integer())
      fail(file, field + ".id", "expected an integer");
    const json name = object.value("name", json(""));
    if (!name.is_string()) fail(file, field + ".name", "expected a text");
    NamedObject entry{object["id"].get<long long>(), name.get<std::string>()};
    if (!entry.subject.empty() && !is_plain_name(entry.subject))
      fail(file, field + ".name", kPlainNameExpected);
    for (char& c : entry.subject) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    named.push_back(entry);
  }
  const std::vector<NamedObject> plain = named;
  for (NamedObject& entry : named) {
    const auto same =
        std::count_if(plain.begin(), plain.end(), [&](const auto& o) { return o.subject == entry.subject; });
    if (entry.subject.empty())
      entry.subject = fmt::format("object_{}", entry.id);
    else if (same > 1)
      entry.subject += fmt::format("_{}", entry.id);
  }
  return named;
}

// A stage may run several times a frame, or not in each: its mean over all frames.
std::map<std::string, double> read_stages(const fs::path& file, const json& root) {
  std::map<std::string, double> stages;
  const auto frames = number_at(file, root, "/timing_ms/frame/n");
  const auto timing = root.find("timing_ms");
  if (!frames || !(*frames > 0)) return stages;
  for (const auto& [stage, figures] : timing->items()) {
    if (!figures.is_object()) fail(file, "timing_ms." + stage, "expected an object with named values");
    const auto mean = number_at(file, figures, "/mean"), n = number_at(file, figures, "/n");
    if (mean && n) stages[stage] = *mean * *n / *frames;
  }
  return stages;
}

// As the run's options say; of programs of others and estimates without any, the errors: no program follows a
// camera without one.
bool read_camera_given(const json& root) {
  const json config = root.value("config", json());
  const json run = config.is_object() ? config.value("estimate", json()) : json();
  const json variant = run.is_object() ? run.value("variant", json()) : json();
  const bool is_external = variant.is_object() && variant.contains("command");
  if (run.is_object() && run.contains("variant") && !is_external) return camera_was_given(run.dump());
  for (const char* part : {"/camera/ape/translation_m/rmse", "/camera/ape/rotation_rad/rmse"})
    if (const json::json_pointer rmse(part); !root.contains(rmse) || root[rmse] != 0) return false;
  return true;
}

std::string read_isolation(const json& root) {
  const json config = root.value("config", json());
  const json run = config.is_object() ? config.value("estimate", json()) : json();
  const json isolation = run.is_object() ? run.value("isolation", json("")) : json("");
  return isolation.is_string() ? isolation.get<std::string>() : "";
}

SizeSteadiness read_size(const fs::path& file, const json& root, std::size_t index) {
  const std::string base = fmt::format("/estimated_objects/{}", index);
  const json& item = root["estimated_objects"][index];
  if (!item.is_object()) fail(file, field_name(base), "expected an object with named values");
  const auto whole = [&](const char* name) {
    const json value = item.value(name, json());
    if (!value.is_number_integer())
      fail(file, field_name(fmt::format("{}/{}", base, name)), "expected an integer");
    return value.get<std::int64_t>();
  };
  const auto number = [&](const std::string& name) {
    const auto value = number_at(file, root, base + name);
    if (!value) fail(file, field_name(base + name), "expected a number");
    return *value;
  };
  if (item.value("semi_axes_median_m", json()).size() != 3)
    fail(file, field_name(base + "/semi_axes_median_m"), "expected three numbers");
  SizeSteadiness size{static_cast<int>(whole("id")), static_cast<std::size_t>(whole("states")),
                      Eigen::Vector3d::Zero(), number("/spread")};
  for (int axis = 0; axis < 3; ++axis)
    size.semi_axes_m[axis] = number(fmt::format("/semi_axes_median_m/{}", axis));
  return size;
}

// Older evaluations have none.
std::vector<SizeSteadiness> read_sizes(const fs::path& file, const json& root) {
  std::vector<SizeSteadiness> sizes;
  if (!root.contains("estimated_objects")) return sizes;
  const json& list = root["estimated_objects"];
  if (!list.is_array()) fail(file, "estimated_objects", "expected a list");
  for (std::size_t i = 0; i < list.size(); ++i) sizes.push_back(read_size(file, root, i));
  return sizes;
}

}  // namespace

CellEvaluation read_cell_evaluation(const fs::path& folder, Frames frames) {
  const fs::path file = folder / "evaluation.json";
  const json root = read_strict_json(file);
  if (!root.is_object()) throw InputError(file, "expected an object with named values");
  if (const auto schema = number_at(file, root, "/schema"); !schema || *schema != kEvaluationSchema)
    fail(file, "schema", fmt::format("this program reads version {}", kEvaluationSchema));
  CellEvaluation evaluation;
  if (const auto program = root.find("program"); program != root.end() && program->is_string())
    evaluation.program = program->get<std::string>();
  if (const auto alignment = root.find("alignment"); alignment != root.end() && alignment->is_object())
    if (const json kind = alignment->value("kind", json()); kind.is_string())
      evaluation.alignment = kind.get<std::string>();
  const std::vector<NamedObject> names = read_names(file, root);
  for (std::size_t i = 0; i < names.size(); ++i)
    evaluation.subjects.push_back(
        read_figures(file, root, fmt::format("/objects/{}", i), names[i].subject, MetricScope::object));
  for (const auto& [base, subject, scope] :
       {std::tuple{"/camera", "camera", MetricScope::camera}, std::tuple{"", "all", MetricScope::all}})
    if (SubjectFigures figures = read_figures(file, root, base, subject, scope); !figures.value.empty())
      evaluation.subjects.push_back(std::move(figures));
  evaluation.camera_given = read_camera_given(root);
  evaluation.isolation = read_isolation(root);
  if (names.empty()) evaluation.sizes = read_sizes(file, root);
  evaluation.stage_ms = read_stages(file, root);
  if (frames == Frames::read) evaluation.series = read_series(folder / "frames.csv", names);
  return evaluation;
}

}  // namespace uniquadric
