#include "harness/commands/commands.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <iostream>
#include <memory>
#include <set>

#include "core/base/error.h"
#include "evaluation/metric.h"
#include "evaluation/metrics/depth_comparison.h"
#include "evaluation/metrics/map_comparison.h"
#include "evaluation/metrics/surface_comparison.h"
#include "harness/commands/options.h"
#include "simulator/scene/mesh_building.h"
#include "simulator/scene/mesh_import.h"

namespace uniquadric {
namespace {

// What metrics over files have in common: two paths, --json, and figures to print.
template <typename Compare>
CLI::App* over_files(CLI::App& app, const char* name, const char* what, const char* first,
                     const char* first_is, const char* second, const char* second_is, Common& common,
                     const Compare& compare) {
  auto* sub = subcommand(app, name, what, common);
  struct Arguments {
    std::string first, second;
    bool json = false;
  };
  auto arguments = std::make_shared<Arguments>();
  sub->add_option(first, arguments->first, first_is)->required();
  sub->add_option(second, arguments->second, second_is)->required();
  sub->add_flag("--json", arguments->json, "as JSON instead of a list");
  sub->callback([arguments, compare] {
    const Figures found = figures(compare(arguments->first, arguments->second));
    std::cout << (arguments->json ? figures_json(found) : figures_text(found));
  });
  return sub;
}

void add_map(CLI::App& app, Common& common) {
  static MapOptions options;
  static std::string unknown;
  auto* sub = over_files(app, "map", "occupancy of two octrees (.bt)", "TRUE", "OctoMap's binary tree",
                         "ESTIMATE", "another of the same world, or PLY points in it", common,
                         [](const std::string& truth, const std::string& estimate) {
                           if (!unknown.empty()) options.unknown_is_free = unknown == "free";
                           return compare_maps(truth, estimate, options);
                         });
  sub->add_option("--resolution", options.resolution_m,
                  "edge of the voxels compared [m]; default: the coarser map's");
  sub->add_option("--unknown", unknown,
                  "what is occupied where TRUE knows nothing: ignored, or wrong (free); default: wrong where "
                  "TRUE lists surfaces alone")
      ->check(CLI::IsMember({"ignored", "free"}));
}

void add_depth(CLI::App& app, Common& common) {
  static DepthOptions options;
  static std::string masks;
  auto* sub = over_files(app, "depth", "error of depth images", "TRUE", "16-bit PNG, or a folder of them",
                         "ESTIMATE", "image, or folder of the same names", common,
                         [](const std::string& truth, const std::string& estimate) {
                           if (options.units_per_m && !(*options.units_per_m > 0))
                             throw InputError("--scale: expected more than 0");
                           options.masks = masks;
                           return compare_depth(truth, estimate, options);
                         });
  sub->add_option("--scale", options.units_per_m,
                  "value of a pixel at 1 m, of images beside no sequence.yaml")
      ->check(at_least_0());
  auto* of_ids = sub->add_option("--masks", masks, "image of ids, or folder of the same names");
  auto* id = sub->add_option("--id", options.id, "whose pixels count")->check(whole_number(0, 65535));
  of_ids->needs(id);
  id->needs(of_ids);
}

Pose parse_pose(const std::vector<double>& v) {
  constexpr double kUnitTolerance = 1e-3;  // as for trajectories that are read
  const Pose pose{{v[6], v[3], v[4], v[5]}, {v[0], v[1], v[2]}};
  if (!(pose.translation.cwiseAbs().maxCoeff() <= kMostCoordinate_m) ||
      !(std::abs(pose.rotation.norm() - 1) <= kUnitTolerance))
    throw InputError("--pose: expected a position and a quaternion of length 1");
  return {pose.rotation.normalized(), pose.translation};
}

SurfaceDistance read_surface(const std::string& file) {
  Mesh whole;
  for (const Mesh& mesh : import_mesh(file).meshes) merge(whole, mesh);
  for (const Eigen::Vector3f& corner : whole.positions)
    if (corner.cwiseAbs().maxCoeff() > kMostCoordinate_m)
      throw InputError(file, fmt::format("reaches beyond {} m", kMostCoordinate_m));
  return {std::move(whole.positions), std::move(whole.triangles)};
}

void add_surface(CLI::App& app, Common& common) {
  static SurfaceOptions options;
  static std::vector<double> pose;
  auto* sub =
      over_files(app, "surface", "distance of points to a surface", "POINTS", "PCD or PLY file", "MESH",
                 "OBJ, PLY and more [m]", common, [](const std::string& points, const std::string& file) {
                   if (!pose.empty()) options.points_from_surface = parse_pose(pose);
                   return compare_to_surface(points, read_surface(file), options);
                 });
  sub->add_option("--pose", pose, "of MESH in the points' frame: tx ty tz qx qy qz qw; default: none")
      ->expected(7);
  sub->add_option("--within", options.within_m, "points up to here are counted [m]; default: 0.05")
      ->check(at_least_0());
}

// A folder or a descriptor that is closed has no lines, and nothing says so.
void require_readable_input() {
  struct stat status {};
  if (fstat(STDIN_FILENO, &status) != 0)
    throw InputError(fmt::format("standard input cannot be read: {}", std::strerror(errno)));
  if (S_ISDIR(status.st_mode)) throw InputError("standard input is a folder");
}

}  // namespace

void add_metric(CLI::App& app, Common& common) {
  auto* sub =
      subcommand(app, "metric", "one figure per JSON line: stdin -> stdout; or figures of files", common);
  static std::string kind;
  static MetricOptions options;
  auto* lines = sub->add_option("KIND", kind, "of JSON lines")->type_name("{iou3d,iou2d,project,pose}");
  sub->add_option("--method", options.method, "of iou3d")->check(CLI::IsMember({"exact", "monte-carlo"}));
  sub->add_option("--samples", options.samples, "of monte-carlo")->check(whole_number(1, kMaxCount));
  sub->add_option("--seed", options.seed, "of monte-carlo")->check(whole_number());
  sub->require_subcommand(0, 1);
  for (const auto add : {add_map, add_depth, add_surface}) add(*sub, common);
  for (CLI::App* of_files : sub->get_subcommands({})) of_files->excludes(lines);
  sub->callback([sub, &common] {
    if (!sub->get_subcommands().empty()) return;
    if (!std::set<std::string>{"iou3d", "iou2d", "project", "pose"}.contains(kind))
      throw InputError(
          fmt::format("metric '{}' is none of iou3d, iou2d, project, pose, map, depth, surface", kind));
    if (sub->count("--method") > 0 && kind != "iou3d")
      throw InputError(fmt::format("--method is of iou3d: {} has one alone", kind));
    for (const char* name : {"--samples", "--seed"})
      if (sub->count(name) > 0 && options.method != "monte-carlo")
        throw InputError(fmt::format("{} requires --method monte-carlo", name));
    require_readable_input();
    common.exit_code = run_metric(kind, options, std::cin, std::cout);
  });
}

}  // namespace uniquadric
