#include "harness/commands/commands.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <iostream>

#include "core/base/apart.h"
#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/warning.h"
#include "evaluation/report/trajectory_picture.h"
#include "evaluation/trajectory_comparison.h"
#include "evaluation/unit_check.h"
#include "harness/commands/options.h"

namespace uniquadric {
namespace {

TrajectoryOptions trajectory_options(const std::string& align, const std::string& relation,
                                     const std::string& part, const std::string& delta, double max_dt_s) {
  TrajectoryOptions options;
  options.alignment = *parse_alignment_kind(align);
  for (const PoseRelation known : {PoseRelation::ape, PoseRelation::rpe})
    if (relation == to_string(known)) options.relations = {known};
  for (const ErrorPart known : {ErrorPart::translation, ErrorPart::rotation, ErrorPart::full})
    if (part == to_string(known)) options.parts = {known};
  const auto step = parse_delta(delta);
  if (!step) throw InputError(fmt::format("--delta: '{}' is no step such as 1f, 10m, 1s, 10deg", delta));
  options.delta.delta = step->value;
  options.delta.unit = step->unit;
  if (max_dt_s > 1e9) throw InputError("--max-dt: expected at most 1e9 s");
  options.association.max_difference_ns = std::llround(max_dt_s * 1e9);
  return options;
}

// How the picture's file is to be written, by its name.
std::string (*picture_writer(const std::string& file))(const Picture&) {
  if (file.ends_with(".svg")) return picture_svg;
  if (file.ends_with(".pdf")) return picture_pdf;
  if (file.ends_with(".png")) return picture_png;
  throw InputError(fmt::format("--plot: '{}' does not end in .svg, .pdf or .png", file));
}

FileKind picture_kind(const std::string& file) {
  if (file.ends_with(".svg")) return {"SVG picture", "<svg"};
  return file.ends_with(".pdf") ? FileKind{"PDF file", "%PDF"} : FileKind{"PNG picture", "\x89PNG"};
}

// An option that would change nothing is taken for a mistake.
void require_used(const CLI::App& sub, const std::string& align, const std::string& relation) {
  const bool evo = sub.count("--compat") > 0;
  if (evo && (align == "poses" || align == "posyaw"))
    throw InputError(fmt::format("--align: evo has no {}, as --compat evo asks for", align));
  if (evo && sub.count("--association") > 0 && sub["--association"]->as<std::string>() == "one_to_one")
    throw InputError("--association: evo has no one_to_one, as --compat evo asks for");
  if (sub.count("--align-n") > 0 && (align == "none" || align == "first"))
    throw InputError(fmt::format("--align-n: --align {} is not fitted on poses", align));
  for (const char* name : {"--delta", "--all-pairs", "--pairs-from"})
    if (sub.count(name) > 0 && relation == "ape")
      throw InputError(fmt::format("{} is of RPE's steps: --relation ape has none", name));
}

}  // namespace

void add_trajectory(CLI::App& app, Common& common) {
  auto* sub = subcommand(app, "trajectory", "APE, RPE, drift, KITTI errors of two TUM trajectories", common);
  static std::string reference, estimate_file, align = "none", relation, part, delta = "1f", from, rule,
                                               compat, plot;
  static double max_dt_s = 0.01;
  static std::size_t align_pairs = 0;
  static bool all_pairs = false, drift = false, kitti = false, as_json = false;
  sub->add_option("REF", reference, "reference (TUM text)")->required();
  sub->add_option("EST", estimate_file, "estimate (TUM text)")->required();
  sub->add_option("--align", align, "of the estimate with the reference, before all else")
      ->check(CLI::IsMember({"none", "first", "se3", "sim3", "scale", "posyaw", "poses"}));
  sub->add_option("--align-n", align_pairs, "fitted on the first N pairs; default: on all")
      ->check(whole_number(1, kMaxCount));
  sub->add_option("--relation", relation, "default: both")->check(CLI::IsMember({"ape", "rpe"}));
  sub->add_option("--part", part, "of the error; default: translation and rotation")
      ->check(CLI::IsMember({"translation", "rotation", "full"}));
  sub->add_option("--delta", delta, "of RPE's steps: 1f, 10m, 1s, 10deg");
  sub->add_flag("--all-pairs", all_pairs, "a step from every pose, not one after the other");
  sub->add_option("--pairs-from", from, "whose poses the steps are measured on; default: ref")
      ->check(CLI::IsMember({"ref", "est"}));
  sub->add_option("--max-dt", max_dt_s, "of two poses that belong together [s]; default: 0.01")
      ->check(at_least_0());
  sub->add_option("--association", rule, "default: nearest")->check(CLI::IsMember({"nearest", "one_to_one"}));
  sub->add_flag("--drift", drift, "and the maximum drift");
  sub->add_flag("--kitti", kitti, "and KITTI's errors over 100 to 800 m");
  sub->add_option("--compat", compat, "choose steps as evo does")->check(CLI::IsMember({"evo"}));
  sub->add_flag("--json", as_json, "as JSON instead of a table");
  sub->add_option("--plot", plot, "picture of the paths and errors to write: .svg, .pdf or .png");
  add_force(sub, common)->description("replace the file of --plot");
  sub->callback([sub, &common] {
    require_used(*sub, align, relation);
    const auto write_picture = plot.empty() ? nullptr : picture_writer(plot);
    TrajectoryOptions options = trajectory_options(align, relation, part, delta, max_dt_s);
    if (align_pairs > 0) options.align_pairs = align_pairs;
    if (!from.empty()) options.pairs_from_reference = from == "ref";
    if (rule == "one_to_one") options.association.rule = StampRule::one_to_one;
    options.delta.all_pairs = all_pairs;
    options.evo = compat == "evo";
    options.drift = drift;
    options.kitti = kitti;
    require_apart(plot, {reference, estimate_file});
    require_replaceable_file(plot, common.force, picture_kind(plot));
    const TrajectoryComparison comparison = compare_trajectories(reference, estimate_file, options);
    if (const auto fault = spread_fault(comparison.pairs.reference, comparison.pairs.estimate);
        fault && !fits_scale(options.alignment))
      warn(estimate_file + ": " + *fault);
    if (write_picture)
      write_text(plot, write_picture(trajectory_picture(
                           comparison, fmt::format("{} against {}", estimate_file, reference))));
    std::cout << (as_json ? trajectory_json(comparison, options) : trajectory_text(comparison, options));
  });
}

}  // namespace uniquadric
