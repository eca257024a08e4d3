// Evaluation's metrics. Those of ellipsoids take and give the JSON lines of `uniquadric metric`, so that both
// refuse the same input with the same text.
#include "evaluation/metric.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <memory>
#include <sstream>
#include <vector>

#include "core/base/error.h"
#include "core/sequence/ply.h"
#include "evaluation/iou/box_iou.h"
#include "evaluation/iou/solid_iou.h"
#include "evaluation/metric_input.h"
#include "evaluation/trajectory_comparison.h"
#include "python/module_parts.h"

namespace uniquadric::python {
namespace {

std::string answer(const std::string& kind, const std::string& line) {
  std::istringstream in(line);
  std::ostringstream out;
  run_metric(kind, {}, in, out);
  return out.str();
}

double box_iou_of(const std::string& text) {
  const MetricLine line(text);
  return box_iou(line.ellipsoid("gt"), line.ellipsoid("est"));
}

MeshSolid mesh_of(const py::array_t<double>& vertices, const py::array_t<std::int64_t>& triangles) {
  const auto points = vertices.unchecked<2>();
  const auto faces = triangles.unchecked<2>();
  std::vector<Eigen::Vector3f> corners;
  for (py::ssize_t i = 0; i < points.shape(0); ++i) {
    const Eigen::Vector3d point(points(i, 0), points(i, 1), points(i, 2));
    if (!(point.cwiseAbs().maxCoeff() <= kMostPlyCoordinate_m))
      throw InputError(fmt::format("vertices[{}]: expected numbers up to {} m", i, kMostPlyCoordinate_m));
    corners.push_back(point.cast<float>());
  }
  std::vector<std::array<std::uint32_t, 3>> corners_of_triangles;
  for (py::ssize_t i = 0; i < faces.shape(0); ++i) {
    auto& triangle = corners_of_triangles.emplace_back();
    for (py::ssize_t k = 0; k < 3; ++k) {
      if (faces(i, k) < 0 || faces(i, k) >= points.shape(0))
        throw InputError(
            fmt::format("triangles[{}]: {} is no index of {} vertices", i, faces(i, k), points.shape(0)));
      triangle[static_cast<std::size_t>(k)] = static_cast<std::uint32_t>(faces(i, k));
    }
  }
  return {corners, corners_of_triangles};
}

// Of what the mesh encloses and the body "est" of a JSON line, whose pose is in the mesh's frame.
double mesh_iou_of(const py::array_t<double>& vertices, const py::array_t<std::int64_t>& triangles,
                   const std::string& text) {
  const PosedBody estimate = MetricLine(text).body("est");
  const MetricOptions options;
  const auto mesh = std::make_shared<MeshSolid>(mesh_of(vertices, triangles));
  const SolidSamples samples({{}, mesh}, options.samples, options.seed);
  if (!(samples.volume() > 0)) throw InputError("triangles: they enclose no volume");
  return solid_iou(samples, estimate.body, estimate.world_from_body).iou;
}

Trajectory trajectory_of(const std::vector<std::int64_t>& stamps_ns, const py::array_t<double>& matrices,
                         const std::string& what) {
  const auto view = matrices.unchecked<3>();
  if (view.shape(1) != 4 || view.shape(2) != 4 || view.shape(0) != static_cast<py::ssize_t>(stamps_ns.size()))
    throw InputError(fmt::format("{}: expected as many 4x4 matrices as there are stamps", what));
  Trajectory trajectory;
  for (std::size_t k = 0; k < stamps_ns.size(); ++k) {
    Eigen::Matrix4d matrix;
    for (int row = 0; row < 4; ++row)
      for (int column = 0; column < 4; ++column)
        matrix(row, column) = view(static_cast<py::ssize_t>(k), row, column);
    append(trajectory, stamps_ns[k], matrix, fmt::format("{}[{}]", what, k));
  }
  return trajectory;
}

// A path, or (stamps, matrices).
Trajectory trajectory_of(const py::object& given, const std::string& what) {
  if (!py::isinstance<py::tuple>(given)) return read_tum(given.cast<std::filesystem::path>());
  const auto pair = given.cast<py::tuple>();
  return trajectory_of(pair[0].cast<std::vector<std::int64_t>>(), pair[1].cast<py::array_t<double>>(), what);
}

template <typename Choice>
Choice choice_of(const std::string& text, std::initializer_list<Choice> known, const char* name) {
  std::string names;
  for (const Choice choice : known) {
    if (text == to_string(choice)) return choice;
    names += (names.empty() ? "" : ", ") + std::string(to_string(choice));
  }
  throw InputError(fmt::format("{}: '{}' is none of {}", name, text, names));
}

struct Choices {
  std::string relation, part, align, delta, association;
  std::optional<std::size_t> align_pairs;
  bool all_pairs;
  double max_dt_s;
};

TrajectoryOptions options_of(const Choices& choices) {
  using enum AlignmentKind;
  TrajectoryOptions options;
  options.relations = {choice_of(choices.relation, {PoseRelation::ape, PoseRelation::rpe}, "relation")};
  options.parts = {
      choice_of(choices.part, {ErrorPart::translation, ErrorPart::rotation, ErrorPart::full}, "part")};
  options.alignment = choice_of(choices.align, {none, first, se3, sim3, scale, posyaw, poses}, "align");
  const auto step = parse_delta(choices.delta);
  if (!step)
    throw InputError(fmt::format("delta: '{}' is no step such as 1f, 10m, 1s, 10deg", choices.delta));
  options.delta.delta = step->value;
  options.delta.unit = step->unit;
  options.delta.all_pairs = choices.all_pairs;
  if (choices.align_pairs == std::size_t{0})
    throw InputError("align_pairs: expected a number greater than 0");
  options.align_pairs = choices.align_pairs;
  if (!(choices.max_dt_s >= 0 && choices.max_dt_s <= 1e9)) throw InputError("max_dt_s: expected 0 to 1e9 s");
  options.association.max_difference_ns = std::llround(choices.max_dt_s * 1e9);
  if (choices.association == "one_to_one")
    options.association.rule = StampRule::one_to_one;
  else if (choices.association != "nearest")
    throw InputError(fmt::format("association: '{}' is none of nearest, one_to_one", choices.association));
  return options;
}

py::dict errors_of(const TrajectoryComparison& comparison) {
  const ErrorSeries& series = comparison.errors.front();
  std::vector<std::int64_t> stamps_ns;
  for (const std::size_t at : series.at) stamps_ns.push_back(comparison.pairs.stamps_ns[at]);
  py::dict result;
  result["unit"] = unit_of(series.part);
  result["stamp_ns"] = array_of(stamps_ns);
  result["values"] = array_of(series.values);
  result["coverage"] = comparison.coverage;
  result["scale"] = comparison.alignment.scale;
  result["reference_from_estimate"] = comparison.alignment.reference_from_estimate.matrix();
  if (const auto s = statistics(series.values)) {
    const std::pair<const char*, double> figures[] = {
        {"rmse", s->rmse}, {"mean", s->mean}, {"median", s->median}, {"std", s->std},
        {"min", s->min},   {"max", s->max},   {"sse", s->sse}};
    for (const auto& [name, value] : figures) result[name] = value;
    result["n"] = s->n;
  }
  return result;
}

py::dict trajectory_errors(const py::object& reference, const py::object& estimate, const Choices& choices) {
  const TrajectoryOptions options = options_of(choices);
  const bool has_arrays = py::isinstance<py::tuple>(reference) || py::isinstance<py::tuple>(estimate);
  if (!has_arrays)
    return errors_of(compare_trajectories(reference.cast<std::filesystem::path>(),
                                          estimate.cast<std::filesystem::path>(), options));
  const Trajectory true_poses = trajectory_of(reference, "reference");
  return errors_of(compare_trajectories(true_poses, trajectory_of(estimate, "estimate"), options));
}

}  // namespace

void add_metrics(py::module_& module) {
  module.def("metric", &answer);
  module.def("box_iou", &box_iou_of);
  module.def("mesh_iou", &mesh_iou_of);
  module.def("trajectory_errors",
             [](const py::object& reference, const py::object& estimate, const std::string& relation,
                const std::string& part, const std::string& align, std::optional<std::size_t> align_pairs,
                const std::string& delta, bool all_pairs, double max_dt_s, const std::string& association) {
               return trajectory_errors(
                   reference, estimate,
                   {relation, part, align, delta, association, align_pairs, all_pairs, max_dt_s});
             });
}

}  // namespace uniquadric::python
