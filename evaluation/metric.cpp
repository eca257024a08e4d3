#include "evaluation/metric.h"

#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <functional>
#include <istream>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <ostream>

#include "core/base/error.h"
#include "core/geometry/box_symmetry.h"
#include "evaluation/align/symmetry.h"
#include "evaluation/image_overlap.h"
#include "evaluation/iou/ellipsoid_iou.h"
#include "evaluation/iou/monte_carlo.h"
#include "evaluation/iou/solid_iou.h"
#include "evaluation/metric_input.h"
#include "evaluation/trajectory/pose_error.h"

namespace uniquadric {
namespace {
using nlohmann::json;
using Answer = std::function<json(const MetricLine&)>;

template <typename T>
json or_null(const std::optional<T>& value) {
  return value ? json(*value) : json();
}

// Of bodies that are not both ellipsoids. The smaller one is sampled: more of its points count.
json answer_solids(const PosedBody& a, const PosedBody& b, const MetricOptions& options) {
  const bool a_is_smaller = superellipsoid_volume(a.body) <= superellipsoid_volume(b.body);
  const PosedBody &sampled = a_is_smaller ? a : b, &other = a_is_smaller ? b : a;
  const SolidSamples samples({sampled.body, {}}, options.samples, options.seed);
  const SolidIou pair =
      solid_iou(samples, other.body, relative_pose(sampled.world_from_body, other.world_from_body));
  const MeanIou iou = mean_iou(std::span(&pair, 1));
  return {{"iou", iou.mean},
          {"stderr", iou.standard_error},
          {"method", iou.standard_error == 0 ? "exact" : "sampled"}};
}

using EllipsoidAnswer = std::function<json(const Ellipsoid&, const Ellipsoid&)>;

// By `of_ellipsoids` for two ellipsoids.
Answer for_any_shape(const MetricOptions& options, const EllipsoidAnswer& of_ellipsoids) {
  return [options, of_ellipsoids](const MetricLine& line) -> json {
    const PosedBody truth = line.body("gt"), estimate = line.body("est");
    if (!is_ellipsoid(truth.body) || !is_ellipsoid(estimate.body))
      return answer_solids(truth, estimate, options);
    return of_ellipsoids({truth.world_from_body, truth.body.semi_axes_m},
                         {estimate.world_from_body, estimate.body.semi_axes_m});
  };
}

Answer answer_iou3d(const MetricOptions& options) {
  if (options.method == "exact")
    return for_any_shape(options, [](const Ellipsoid& truth, const Ellipsoid& estimate) -> json {
      return {{"iou", ellipsoid_iou(truth, estimate)}, {"stderr", 0.0}, {"method", "exact"}};
    });
  if (options.method != "monte-carlo")
    throw InputError(fmt::format("method '{}' is none of exact, monte-carlo", options.method));
  if (options.samples < 1) throw InputError("samples: expected a number greater than 0");
  const auto samples = std::make_shared<BallSamples>(options.samples, options.seed);
  return for_any_shape(options, [samples](const Ellipsoid& truth, const Ellipsoid& estimate) -> json {
    const auto [iou, error] = ellipsoid_iou_monte_carlo(truth, estimate, *samples);
    return {{"iou", iou}, {"stderr", error}, {"method", "monte-carlo"}};
  });
}

json answer_project(const MetricLine& line) {
  const auto [camera, world_from_camera] = line.camera();
  const Ellipsoid body = line.ellipsoid("gt");
  const EllipseProjection outline =
      project(camera, relative_pose(world_from_camera, body.world_from_object), body.semi_axes_m);
  if (outline.status != ProjectionStatus::ok) return {{"status", to_string(outline.status)}};
  const Ellipse& e = outline.ellipse;
  return {{"status", "ok"},
          {"centre", {e.center.x(), e.center.y()}},
          {"semi_major", e.semi_major},
          {"semi_minor", e.semi_minor},
          {"angle_deg", e.angle_rad * 180 / std::numbers::pi}};
}

json answer_iou2d(const MetricLine& line) {
  const auto [camera, world_from_camera] = line.camera();
  const Ellipsoid truth = line.ellipsoid("gt"), estimate = line.ellipsoid("est");
  const ImageOverlap overlap =
      overlap_in_image(camera, {world_from_camera, truth}, {world_from_camera, estimate});
  const bool truth_ok = overlap.truth_status == ProjectionStatus::ok;
  return {{"status", to_string(truth_ok ? overlap.estimate_status : overlap.truth_status)},
          {"gt_status", to_string(overlap.truth_status)},
          {"est_status", to_string(overlap.estimate_status)},
          {"rect_iou", or_null(overlap.rectangle_iou)},
          {"ellipse_iou", or_null(overlap.ellipse_iou)},
          {"aabb_iou", or_null(overlap.box_iou)},
          {"rect_iou_clipped", or_null(overlap.clipped_rectangle_iou)}};
}

json answer_pose(const MetricLine& line) {
  const Ellipsoid truth = line.ellipsoid("gt"), estimate = line.ellipsoid("est");
  const Ellipsoid renamed = relabel_axes(estimate, best_relabelling({estimate}, {truth}));
  const PoseError error = absolute_error(truth.world_from_object, estimate.world_from_object);
  const Eigen::Vector3d axes = renamed.semi_axes_m - truth.semi_axes_m;
  return {{"translation_error_m", error.translation_m},
          {"rotation_error_naive_rad", error.rotation_rad},
          {"rotation_error_symmetric_rad", or_null(symmetric_rotation_error(renamed, truth))},
          {"axis_errors_m", {axes.x(), axes.y(), axes.z()}},
          {"d_shape_m", shape_distance_m(estimate, truth)}};
}

// Of every kind: a line may be asked several.
constexpr std::array<std::string_view, 4> kLineKeys = {"camera", "est", "gt", "id"};

Answer answer_for(const std::string& kind, const MetricOptions& options) {
  if (kind == "iou3d") return answer_iou3d(options);
  if (kind == "iou2d") return answer_iou2d;
  if (kind == "project") return answer_project;
  if (kind == "pose") return answer_pose;
  throw InputError(fmt::format("metric '{}' is none of iou3d, iou2d, project, pose", kind));
}

constexpr std::size_t kMostLineBytes = 1 << 20;  // ours: a line has some hundred

// As std::getline, but of a longer line no more than one byte above the most.
bool next_line(std::istream& in, std::string& line) {
  line.clear();
  std::streambuf& bytes = *in.rdbuf();
  constexpr int kEnd = std::char_traits<char>::eof();
  int byte = bytes.sbumpc();
  if (byte == kEnd) return false;
  for (; byte != kEnd && byte != '\n'; byte = bytes.sbumpc())
    if (line.size() <= kMostLineBytes) line += static_cast<char>(byte);
  return true;
}

}  // namespace

int run_metric(const std::string& kind, const MetricOptions& options, std::istream& in, std::ostream& out) {
  const Answer answer = answer_for(kind, options);
  int exit_code = 0, number = 0;
  for (std::string line; next_line(in, line);) {
    ++number;
    if (line.find_first_not_of(" \t\r") == line.npos) continue;
    json result, id;
    try {
      if (line.size() > kMostLineBytes)
        throw InputError(fmt::format("is longer than {} bytes", kMostLineBytes));
      const MetricLine input(line);
      id = json::parse(input.id_json());
      input.refuse_other_keys(kLineKeys);
      result = answer(input);
    } catch (const InputError& e) {
      result = {{"error", e.what()}, {"line", number}};
      if (id.is_null()) id = json::parse(stated_id_json(line));
      exit_code = 2;
    }
    result["id"] = id;
    out << result.dump(-1, ' ', false, json::error_handler_t::replace)
        << std::endl;  // at once: it may be a dialogue
    if (!out) throw InputError(fmt::format("the answer cannot be written: {}", std::strerror(errno)));
  }
  return exit_code;
}

}  // namespace uniquadric
