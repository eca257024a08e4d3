// The program: each subcommand parses its options and calls one function.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <csignal>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iostream>
#include <limits>

#include "core/base/apart.h"
#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/text.h"
#include "core/base/version.h"
#include "core/sequence/import_kitti.h"
#include "core/sequence/import_tum.h"
#include "estimator/estimate.h"
#include "evaluation/evaluate.h"
#include "evaluation/metric.h"
#include "evaluation/report/overlay.h"
#include "evaluation/report/report.h"
#include "evaluation/report/trajectory_svg.h"
#include "evaluation/trajectory_comparison.h"
#include "harness/bench/bench.h"
#include "harness/bench/process.h"
#include "harness/check.h"
#include "harness/export/export.h"
#include "harness/info.h"
#include "harness/perception_info.h"
#include "simulator/preview.h"
#include "simulator/scene/noise_scale.h"
#include "simulator/scene/scene.h"
#include "simulator/simulate.h"

namespace uniquadric {
namespace {

constexpr int kBadInput = 2;

struct Common {
  bool quiet = false;
  bool force = false;
  int threads = 0;
};

// A whole number of at least `least` and at most `most`, digits only: CLI11 itself lets -5 wrap around.
CLI::Validator whole_number(std::uint64_t least = 0,
                            std::uint64_t most = std::numeric_limits<std::uint64_t>::max()) {
  return {[least, most](const std::string& text) {
            std::uint64_t value = 0;
            const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
            if (error == std::errc{} && end == text.data() + text.size() && value >= least && value <= most)
              return std::string();
            return fmt::format("'{}' is no whole number from {} to {}", text, least, most);
          },
          ""};
}
// A finite number of at least 0.
const CLI::Validator kAtLeast0(
    [](const std::string& text) {
      const auto value = parse_double(text);
      return value && *value >= 0 ? std::string() : fmt::format("'{}' is no number of at least 0", text);
    },
    "");
constexpr std::uint64_t kMaxCount = 10'000'000;

// The options that every subcommand has.
CLI::App* subcommand(CLI::App& app, const std::string& name, const std::string& what, Common& common) {
  CLI::App* sub = app.add_subcommand(name, what);
  sub->add_flag("-q,--quiet", common.quiet, "no progress on stderr");
  sub->add_option("--threads", common.threads, "threads to use; 0: as many as there are cores")
      ->check(whole_number(0, kMaxCount));
  return sub;
}

void add_force(CLI::App* sub, Common& common) {
  sub->add_flag("--force", common.force, "replace OUT when it exists");
}

void add_simulate(CLI::App& app, Common& common) {
  auto* sub = subcommand(app, "simulate", "scene file -> sequence with exact ground truth", common);
  static std::string scene, out;
  static SimulateOptions options;
  static std::int64_t frames = 0;
  static std::string gl = "osmesa";
  static double noise_scale = 1;
  sub->add_option("SCENE", scene, "scene file (YAML)")->required();
  sub->add_option("OUT", out, "folder for sequence/ and truth/")->required();
  sub->add_option("--seed", options.seed, "of all noise")->check(whole_number());
  sub->add_option("--noise-scale", noise_scale, "of the amplitudes of all noise")
      ->check(kAtLeast0)
      ->check(CLI::Range(0.0, kMostNoiseScale));
  auto* count =
      sub->add_option("--frames", frames, "instead of the scene's number")->check(whole_number(1, kMaxCount));
  sub->add_option("--gl", gl,
                  "what draws: osmesa, or egl (without a screen; a graphics card's bytes are its own)")
      ->check(CLI::IsMember({"osmesa", "egl"}));
  sub->add_option("--timing", options.timing, "file for what each stage took (CSV)");
  add_force(sub, common);
  sub->callback([&common, count] {
    options.gl = gl == "egl" ? GlLibrary::egl : GlLibrary::osmesa;
    options.threads = common.threads;
    options.quiet = common.quiet;
    options.force = common.force;
    if (count->count() > 0) options.frames = frames;
    require_apart(out, {scene});
    require_apart(options.timing, {scene});
    Scene loaded = load_scene(scene);
    scale_noise(loaded, noise_scale);
    simulate(loaded, options, out);
  });
}

void add_preview(CLI::App& app, Common& common) {
  auto* sub = subcommand(app, "preview", "scene file -> a picture of some of its frames", common);
  static std::string scene, out;
  static PreviewOptions options;
  sub->add_option("SCENE", scene, "scene file (YAML)")->required();
  sub->add_option("OUT", out, "the picture (JPEG)")->required();
  sub->add_option("--frames", options.frames, "how many, side by side")->check(whole_number(1, 100));
  sub->add_option("--width", options.width_px, "of the picture, in pixels")->check(whole_number(1, 16384));
  sub->callback([] {
    require_apart(out, {scene});
    write_preview(load_scene(scene), options, out);
  });
}

void add_estimate(CLI::App& app, Common& common) {
  auto* sub = subcommand(app, "estimate", "sequence -> 9-DoF tracks of every object", common);
  static std::string sequence, out, variant, prompt = "everything", perception, output;
  static EstimateOptions options;
  sub->add_option("SEQUENCE", sequence, "sequence folder")->required();
  sub->add_option("OUT", out, "folder for the estimate")->required();
  sub->add_option("--perception", perception, "folder that keeps the perception stage's result, or has it");
  sub->add_option("--variant", variant, "variant file (YAML); default: single_frame_obb");
  sub->add_option("--seed", options.seed, "of the estimator's own sampling")->check(whole_number());
  static std::uint64_t perception_seed = 0;
  auto* own_seed = sub->add_option("--perception-seed", perception_seed,
                                   "of the perception stage's, for seeds to share one; default: --seed")
                       ->check(whole_number());
  sub->add_option("--prompt", prompt, "everything, points:FILE, or boxes:FILE or folder");
  auto* as_of =
      sub->add_option("--output", output,
                      "states as of their frame (causal) or of the end (final), instead of the variant's")
          ->check(CLI::IsMember({"causal", "final"}));
  add_force(sub, common);
  sub->callback([&common, as_of, own_seed] {
    if (own_seed->count() > 0) options.perception_seed = perception_seed;
    options.threads = common.threads;
    options.quiet = common.quiet;
    options.force = common.force;
    options.perception = perception;
    options.prompts = parse_prompts(prompt);
    require_apart(out, {sequence, variant, perception, options.prompts.path});
    require_apart(perception, {sequence, variant, options.prompts.path});
    Variant chosen = variant.empty() ? default_variant() : load_variant(variant);
    if (as_of->count() > 0) chosen.output = output == "causal" ? Output::causal : Output::final;
    estimate(sequence, chosen, options, out);
  });
}

void add_perceive(CLI::App& app, Common& common) {
  auto* sub =
      subcommand(app, "perceive", "the perception stage of estimate alone, for variants to share", common);
  static std::string sequence, out, variant, prompt = "everything";
  static EstimateOptions options;
  sub->add_option("SEQUENCE", sequence, "sequence folder")->required();
  sub->add_option("OUT", out, "folder for its result, for estimate's --perception")->required();
  sub->add_option("--variant", variant, "variant file (YAML); default: single_frame_obb");
  sub->add_option("--seed", options.seed, "of the estimator's own sampling")->check(whole_number());
  sub->add_option("--prompt", prompt, "everything, points:FILE, or boxes:FILE or folder");
  add_force(sub, common);
  sub->callback([&common] {
    options.threads = common.threads;
    options.quiet = common.quiet;
    options.force = common.force;
    options.perception = out;
    options.prompts = parse_prompts(prompt);
    require_apart(out, {sequence, variant, options.prompts.path});
    keep_perception(sequence, variant.empty() ? default_variant() : load_variant(variant), options);
  });
}

void add_evaluate(CLI::App& app, Common& common) {
  auto* sub = subcommand(app, "evaluate", "truth and estimate -> evaluation.json, frames.csv", common);
  static std::string truth, estimate_folder, out;
  static EvaluateOptions options;
  sub->add_option("TRUTH", truth, "truth folder")->required();
  sub->add_option("ESTIMATE", estimate_folder, "estimate folder")->required();
  sub->add_option("OUT", out, "folder for the evaluation")->required();
  sub->add_option("--samples", options.iou_samples, "of the Monte Carlo 3D IoU")
      ->check(whole_number(1, kMaxCount));
  sub->add_option("--seed", options.seed, "of those samples")->check(whole_number());
  static std::string alignment = "auto";
  sub->add_option(
         "--align", alignment,
         "the estimate's world with the truth's, by the camera; auto: none where its poses were given, "
         "else poses")
      ->check(CLI::IsMember({"auto", "none", "first", "se3", "sim3", "scale", "posyaw", "poses"}));
  static std::string body_frame = "none";
  sub->add_option("--body-frame", body_frame, "each object's frame with the true one, for its pose errors")
      ->check(CLI::IsMember({"none", "first", "fit"}));
  add_force(sub, common);
  sub->callback([&common] {
    options.quiet = common.quiet;
    options.force = common.force;
    options.alignment = parse_alignment_kind(alignment);
    options.body_frame = *parse_body_frame(body_frame);
    require_apart(out, {truth, estimate_folder});
    evaluate(truth, estimate_folder, options, out);
  });
}

std::string command_line(int argc, char** argv) {
  std::string text = "uniquadric";
  for (int i = 1; i < argc; ++i) text += std::string(" ") + argv[i];
  return text;
}

void add_bench(CLI::App& app, Common& common, int& exit_code, const std::string& command) {
  auto* sub = subcommand(app, "bench", "scenes x variants x seeds -> report; resumes", common);
  static std::string config, out;
  static BenchOptions options;
  sub->add_option("BENCH", config, "bench file (YAML)")->required();
  sub->add_option("OUT", out, "results folder")->required();
  sub->add_option("--jobs", options.jobs, "stages at once; default: as many as there are cores")
      ->check(whole_number(1, kMaxCount));
  sub->add_flag("--keep", options.keep_sequences, "keep the sequences");
  sub->add_flag("--force", common.force, "write into OUT though it holds other things than results");
  sub->callback([&common, &exit_code, &command] {
    options.quiet = common.quiet;
    options.force = common.force;
    options.command = command;
    require_apart(out, {config});
    const int failed = bench(config, out, options);
    std::cout << summary_table(out) << "report: " << out << "/report.html\n";
    if (failed > 0) {
      std::cerr << fmt::format("uniquadric: {} cells failed; see {}/cells.csv\n", failed, out);
      exit_code = kBadInput;
    }
  });
}

void add_report(CLI::App& app, Common& common) {
  auto* sub = subcommand(app, "report", "results -> report.html, report.md, scores.csv", common);
  static std::string results;
  static bool open = false;
  sub->add_option("RESULTS", results, "results folder of bench")->required();
  sub->add_flag("--open", open, "show it in the desktop's browser");
  sub->callback([] {
    write_report(results);
    std::cout << results << "/report.html\n";
    if (!open) return;
    const ProcessResult shown =
        run_process({"/usr/bin/env", "xdg-open", results + "/report.html"}, "/dev/null", 60);
    if (!shown.ok) throw std::runtime_error("the report cannot be shown: " + shown.message);
  });
}

void add_overlay(CLI::App& app, Common& common) {
  auto* sub = subcommand(app, "overlay", "frames with masks and outlines drawn in", common);
  static std::string sequence, estimate_folder, out, truth;
  static int count = 16;
  sub->add_option("SEQUENCE", sequence, "sequence folder")->required();
  sub->add_option("ESTIMATE", estimate_folder, "estimate folder")->required();
  sub->add_option("OUT", out, "folder for the pictures and sheet.jpg")->required();
  sub->add_option("--truth", truth, "truth folder, to draw true outlines too");
  sub->add_option("--count", count, "frames, evenly spaced")->check(whole_number(1, kMaxCount));
  add_force(sub, common);
  sub->callback([&common] {
    require_apart(out, {sequence, truth, estimate_folder});
    write_overlays(sequence, truth, estimate_folder, out, count, common.force);
  });
}

void add_info(CLI::App& app, Common& common, int& exit_code) {
  auto* sub = subcommand(app, "info", "what a folder or file is", common);
  static std::string path;
  static bool check = false;
  sub->add_option("PATH", path,
                  "sequence, truth, perception, estimate, results; scene, variant, bench or .tum file")
      ->required();
  sub->add_flag("--check", check,
                "verify a sequence (counts, stamps, images, calibration, hashes) or a kept perception");
  sub->callback([&exit_code] {
    std::cout << describe(path);
    if (!check) return;
    const std::vector<std::string> problems =
        is_perception(path) ? check_perception(path) : check_sequence(path);
    for (const std::string& problem : problems) std::cout << "problem: " << problem << '\n';
    std::cout << fmt::format("{} problems\n", problems.size());
    if (!problems.empty()) exit_code = kBadInput;
  });
}

void add_metric(CLI::App& app, Common& common, int& exit_code) {
  auto* sub = subcommand(app, "metric", "one figure per JSON line: stdin -> stdout", common);
  static std::string kind;
  static MetricOptions options;
  sub->add_option("KIND", kind, "iou3d, iou2d, project or pose")
      ->required()
      ->check(CLI::IsMember({"iou3d", "iou2d", "project", "pose"}));
  sub->add_option("--method", options.method, "of iou3d")->check(CLI::IsMember({"exact", "monte-carlo"}));
  sub->add_option("--samples", options.samples, "of monte-carlo")->check(whole_number(1, kMaxCount));
  sub->add_option("--seed", options.seed, "of monte-carlo")->check(whole_number());
  sub->callback([&exit_code] { exit_code = run_metric(kind, options, std::cin, std::cout); });
}

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
  sub->add_option("--align-n", align_pairs, "by the first N pairs; default: by all")
      ->check(whole_number(1, kMaxCount));
  sub->add_option("--relation", relation, "default: both")->check(CLI::IsMember({"ape", "rpe"}));
  sub->add_option("--part", part, "of the error; default: translation and rotation")
      ->check(CLI::IsMember({"translation", "rotation", "full"}));
  sub->add_option("--delta", delta, "of RPE's steps: 1f, 10m, 1s, 10deg");
  sub->add_flag("--all-pairs", all_pairs, "a step from every pose, not one after the other");
  sub->add_option("--pairs-from", from, "whose poses the steps are measured on; default: ref")
      ->check(CLI::IsMember({"ref", "est"}));
  sub->add_option("--max-dt", max_dt_s, "of two poses that belong together [s]; default: 0.01")
      ->check(kAtLeast0);
  sub->add_option("--association", rule, "default: nearest")->check(CLI::IsMember({"nearest", "one_to_one"}));
  sub->add_flag("--drift", drift, "and the maximum drift");
  sub->add_flag("--kitti", kitti, "and KITTI's errors over 100 to 800 m");
  sub->add_option("--compat", compat, "choose steps as evo does")->check(CLI::IsMember({"evo"}));
  sub->add_flag("--json", as_json, "as JSON instead of a table");
  sub->add_option("--plot", plot, "picture of the paths and errors to write (SVG)");
  sub->callback([] {
    TrajectoryOptions options = trajectory_options(align, relation, part, delta, max_dt_s);
    if (align_pairs > 0) options.align_pairs = align_pairs;
    if (!from.empty()) options.pairs_from_reference = from == "ref";
    if (rule == "one_to_one") options.association.rule = StampRule::one_to_one;
    options.delta.all_pairs = all_pairs;
    options.evo = compat == "evo";
    options.drift = drift;
    options.kitti = kitti;
    require_apart(plot, {reference, estimate_file});
    const TrajectoryComparison comparison = compare_trajectories(reference, estimate_file, options);
    if (!plot.empty())
      write_text(plot, trajectory_svg(comparison, fmt::format("{} against {}", estimate_file, reference)));
    std::cout << (as_json ? trajectory_json(comparison, options) : trajectory_text(comparison, options));
  });
}

void add_import_kitti(CLI::App& app, Common& common) {
  auto* sub = subcommand(app, "kitti-tracking", "a recording of KITTI's tracking benchmark", common);
  static std::string source, out;
  static ImportKittiOptions options;
  sub->add_option("SRC", source, "folder with image_02/ or velodyne/, calib/, ...")->required();
  sub->add_option("OUT", out, "folder for sequence/ and, of labels, truth/")->required();
  sub->add_option("--drive", options.drive, "which recording (0000); default: the only one");
  add_force(sub, common);
  sub->callback([&common] {
    options.quiet = common.quiet;
    options.force = common.force;
    require_apart(out, {source});
    import_kitti_tracking(source, options, out);
  });
}

void add_import(CLI::App& app, Common& common) {
  auto* sub = app.add_subcommand("import", "a real recording -> sequence");
  sub->require_subcommand(1);
  add_import_kitti(*sub, common);
  auto* tum = subcommand(*sub, "tum", "a TUM RGB-D recording", common);
  static std::string source, out, camera;
  static ImportTumOptions options;
  tum->add_option("SRC", source, "folder with rgb.txt, depth.txt")->required();
  tum->add_option("OUT", out, "sequence folder")->required();
  tum->add_option("--camera", camera, "calibration; default: SRC/camera.yaml");
  add_force(tum, common);
  tum->callback([&common] {
    options.camera = camera;
    options.quiet = common.quiet;
    options.force = common.force;
    require_apart(out, {source, camera});
    import_tum(source, options, out);
  });
}

void add_export(CLI::App& app, Common& common) {
  auto* sub = subcommand(app, "export", "a sequence -> another tool's format", common);
  static std::string format, sequence, out, truth;
  static ExportOptions options;
  sub->add_option("FORMAT", format, fmt::format("{}", fmt::join(export_formats(), ", ")))
      ->required()
      ->check(CLI::IsMember(export_formats()));
  sub->add_option("SEQUENCE", sequence, "sequence folder")->required();
  sub->add_option("OUT", out, "folder for the export")->required();
  sub->add_option("--truth", truth, "truth folder; default: the one beside the sequence");
  sub->add_option("--frame-stride", options.frame_stride, "ply: every which frame")
      ->check(whole_number(1, kMaxCount));
  sub->add_option("--pixel-stride", options.pixel_stride, "ply: every which pixel")
      ->check(whole_number(1, kMaxCount));
  add_force(sub, common);
  sub->callback([&common] {
    options.truth = truth;
    options.quiet = common.quiet;
    options.force = common.force;
    require_apart(out, {sequence, truth});
    export_sequence(format, sequence, out, options);
  });
}

int run(int argc, char** argv) {
  CLI::App app("uniquadric: simulate, estimate and evaluate object-level SLAM with moving objects");
  app.set_version_flag("--version", kProgram);
  app.require_subcommand(1);
  Common common;
  int exit_code = 0;
  const std::string command = command_line(argc, argv);
  add_simulate(app, common);
  add_preview(app, common);
  add_estimate(app, common);
  add_perceive(app, common);
  add_evaluate(app, common);
  add_bench(app, common, exit_code, command);
  add_report(app, common);
  add_overlay(app, common);
  add_info(app, common, exit_code);
  add_metric(app, common, exit_code);
  add_trajectory(app, common);
  add_import(app, common);
  add_export(app, common);
  if (argc > 1 && argv[1][0] != '-' &&
      app.get_subcommands([&](const CLI::App* sub) { return sub->get_name() == argv[1]; }).empty()) {
    std::cerr << fmt::format("uniquadric: there is no subcommand '{}'; see uniquadric --help\n", argv[1]);
    return kBadInput;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);
    std::cerr << "uniquadric: " << e.what() << "; see uniquadric --help\n";
    return kBadInput;
  } catch (const std::filesystem::filesystem_error& e) {
    std::cerr << fmt::format("uniquadric: {}: {}\n", e.path1().string(), e.code().message());
    return kBadInput;
  } catch (const std::exception& e) {
    std::cerr << "uniquadric: " << e.what() << '\n';
    return kBadInput;
  }
  if (!std::cout.flush()) {
    std::cerr << fmt::format("uniquadric: standard output cannot be written: {}\n", std::strerror(errno));
    return kBadInput;
  }
  return exit_code;
}

}  // namespace
}  // namespace uniquadric

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file larger than may be is a write that fails, and is said
  return uniquadric::run(argc, argv);
}
