// The program: each subcommand parses its options and calls one function.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <fstream>
#include <iostream>

#include "core/base/error.h"
#include "core/base/version.h"
#include "core/sequence/import_tum.h"
#include "estimator/estimate.h"
#include "evaluation/evaluate.h"
#include "evaluation/metric.h"
#include "evaluation/report/overlay.h"
#include "evaluation/report/report.h"
#include "harness/bench/bench.h"
#include "harness/info.h"
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

// The options that every subcommand has.
CLI::App* subcommand(CLI::App& app, const std::string& name, const std::string& what, Common& common) {
  CLI::App* sub = app.add_subcommand(name, what);
  sub->add_flag("-q,--quiet", common.quiet, "no progress on stderr");
  sub->add_option("--threads", common.threads, "threads to use; 0: as many as there are cores")
      ->check(CLI::NonNegativeNumber);
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
  sub->add_option("SCENE", scene, "scene file (YAML)")->required();
  sub->add_option("OUT", out, "folder for sequence/ and truth/")->required();
  sub->add_option("--seed", options.seed, "of all noise");
  auto* count =
      sub->add_option("--frames", frames, "instead of the scene's number")->check(CLI::PositiveNumber);
  add_force(sub, common);
  sub->callback([&common, count] {
    options.threads = common.threads;
    options.quiet = common.quiet;
    options.force = common.force;
    if (count->count() > 0) options.frames = frames;
    simulate(load_scene(scene), options, out);
  });
}

void add_estimate(CLI::App& app, Common& common) {
  auto* sub = subcommand(app, "estimate", "sequence -> 9-DoF tracks of every object", common);
  static std::string sequence, out, variant, prompt = "everything";
  static EstimateOptions options;
  sub->add_option("SEQUENCE", sequence, "sequence folder")->required();
  sub->add_option("OUT", out, "folder for the estimate")->required();
  sub->add_option("--variant", variant, "variant file (YAML); default: single_frame_obb");
  sub->add_option("--seed", options.seed, "of the estimator's own sampling");
  sub->add_option("--prompt", prompt, "everything, or a file or folder of box or point prompts");
  add_force(sub, common);
  sub->callback([&common] {
    options.threads = common.threads;
    options.quiet = common.quiet;
    options.force = common.force;
    if (prompt != "everything") options.prompts = prompt;
    estimate(sequence, variant.empty() ? Variant{} : load_variant(variant), options, out);
  });
}

void add_evaluate(CLI::App& app, Common& common) {
  auto* sub = subcommand(app, "evaluate", "truth and estimate -> evaluation.json, frames.csv", common);
  static std::string truth, estimate_folder, out;
  static EvaluateOptions options;
  sub->add_option("TRUTH", truth, "truth folder")->required();
  sub->add_option("ESTIMATE", estimate_folder, "estimate folder")->required();
  sub->add_option("OUT", out, "folder for the evaluation")->required();
  sub->add_option("--samples", options.iou_samples, "of the Monte Carlo 3D IoU")->check(CLI::PositiveNumber);
  sub->add_option("--seed", options.seed, "of those samples");
  add_force(sub, common);
  sub->callback([&common] {
    options.quiet = common.quiet;
    options.force = common.force;
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
      ->check(CLI::PositiveNumber);
  sub->add_flag("--keep", options.keep_sequences, "keep the sequences");
  sub->callback([&common, &exit_code, &command] {
    options.quiet = common.quiet;
    options.command = command;
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
    if (open && std::system(fmt::format("xdg-open '{}/report.html'", results).c_str()) != 0)
      throw std::runtime_error("xdg-open could not show the report");
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
  sub->add_option("--count", count, "frames, evenly spaced")->check(CLI::NonNegativeNumber);
  add_force(sub, common);
  sub->callback([&common] { write_overlays(sequence, truth, estimate_folder, out, count, common.force); });
}

void add_info(CLI::App& app, Common& common) {
  auto* sub = subcommand(app, "info", "what a folder or file is", common);
  static std::string path;
  sub->add_option("PATH", path, "anything this program reads or writes")->required();
  sub->callback([] { std::cout << describe(path); });
}

void add_metric(CLI::App& app, Common& common, int& exit_code) {
  auto* sub = subcommand(app, "metric", "one figure per JSON line: stdin -> stdout", common);
  static std::string kind;
  static MetricOptions options;
  sub->add_option("KIND", kind, "iou3d, iou2d, project or pose")
      ->required()
      ->check(CLI::IsMember({"iou3d", "iou2d", "project", "pose"}));
  sub->add_option("--method", options.method, "of iou3d")->check(CLI::IsMember({"exact", "monte-carlo"}));
  sub->add_option("--samples", options.samples, "of monte-carlo")->check(CLI::PositiveNumber);
  sub->add_option("--seed", options.seed, "of monte-carlo");
  sub->callback([&exit_code] { exit_code = run_metric(kind, options, std::cin, std::cout); });
}

void add_import(CLI::App& app, Common& common) {
  auto* sub = app.add_subcommand("import", "a real recording -> sequence");
  sub->require_subcommand(1);
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
    import_tum(source, options, out);
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
  add_estimate(app, common);
  add_evaluate(app, common);
  add_bench(app, common, exit_code, command);
  add_report(app, common);
  add_overlay(app, common);
  add_info(app, common);
  add_metric(app, common, exit_code);
  add_import(app, common);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);
    std::cerr << "uniquadric: " << e.what() << "; see uniquadric --help\n";
    return kBadInput;
  } catch (const std::exception& e) {
    std::cerr << "uniquadric: " << e.what() << '\n';
    return kBadInput;
  }
  return exit_code;
}

}  // namespace
}  // namespace uniquadric

int main(int argc, char** argv) {
  return uniquadric::run(argc, argv);
}
