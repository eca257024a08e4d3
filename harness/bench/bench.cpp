#include "harness/bench/bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <thread>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/progress.h"
#include "core/base/text.h"
#include "core/base/threads.h"
#include "estimator/variant.h"
#include "evaluation/report/report.h"
#include "harness/bench/config.h"
#include "harness/bench/keys.h"
#include "harness/bench/process.h"
#include "harness/bench/task_pool.h"
#include "simulator/scene/noise_scale.h"
#include "simulator/scene/scene.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

// One (scene, variant, seed).
struct Cell {
  std::string scene, variant;
  std::uint64_t seed;
  fs::path variant_file;
  fs::path folder;                            // relative to the results
  std::optional<std::string> perception_key;  // nothing: it runs joined with the back end, and is not kept
  std::string estimate_key;
  std::string failure;  // empty: none

  std::string label() const { return fmt::format("{} / {} / seed {}", scene, variant, seed); }
};

// One (scene, seed) with the cells that read its sequence.
struct Simulation {
  std::string scene;
  fs::path scene_file, folder;
  double noise_scale;
  std::uint64_t seed;
  std::string key;
  std::vector<Cell> cells;
  std::atomic<int> unfinished{0};
};

struct Run {
  const BenchConfig& config;
  fs::path out;
  int threads;  // of each stage
  bool keep_sequences;
  Progress& progress;
  TaskPool& pool;
};

std::optional<std::string> shared_perception_key(const Simulation& simulation, const Variant& variant) {
  if (variant.feedback == Feedback::backend) return std::nullopt;
  return perception_key(simulation.key, perception_yaml(variant), simulation.seed);
}

std::vector<std::unique_ptr<Simulation>> plan(const BenchConfig& config) {
  std::vector<std::unique_ptr<Simulation>> simulations;
  std::vector<Variant> variants;
  for (const auto& variant : config.variants) {
    variants.push_back(load_variant(variant.path));
    variants.back().output = config.output.value_or(variants.back().output);
  }
  for (const auto& scene : config.scenes) {
    Scene loaded = load_scene(scene.path);
    scale_noise(loaded, scene.noise_scale);
    for (const auto seed : scene.seeds) {
      auto simulation = std::make_unique<Simulation>();
      simulation->scene = scene.name;
      simulation->scene_file = scene.path;
      simulation->noise_scale = scene.noise_scale;
      simulation->seed = seed;
      simulation->folder = fmt::format("simulations/{}/seed_{}", scene.name, seed);
      simulation->key = simulation_key(loaded.hash, seed, config.frames);
      for (std::size_t v = 0; v < config.variants.size(); ++v) {
        const auto& variant = config.variants[v];
        simulation->cells.push_back({scene.name, variant.name, seed, variant.path,
                                     fmt::format("cells/{}/{}/seed_{}", scene.name, variant.name, seed),
                                     shared_perception_key(*simulation, variants[v]),
                                     estimate_key(simulation->key, variant_yaml(variants[v]), seed), ""});
      }
      simulations.push_back(std::move(simulation));
    }
  }
  return simulations;
}

bool is_done(const Run& run, const Cell& cell) {
  const fs::path folder = run.out / cell.folder;
  return is_current(folder / "estimate", cell.estimate_key) &&
         is_current(folder / "evaluation", evaluation_key(cell.estimate_key)) &&
         (run.config.overlays == 0 ||
          is_current(folder / "overlays", overlay_key(cell.estimate_key, run.config.overlays)));
}

// Variants that agree in their perception share its result; it goes with the sequence.
fs::path perception_folder(const Run& run, const Simulation& simulation, const Cell& cell) {
  return run.out / (simulation.folder.string() + "/perception_" + *cell.perception_key);
}

// Runs a subcommand of this program that makes `folder`, unless it is there already.
ProcessResult run_stage(const Run& run, const fs::path& folder, const std::string& key,
                        std::vector<std::string> command, const fs::path& log) {
  if (is_current(folder, key)) return {true, ""};
  fs::create_directories(folder.parent_path());
  forget_key(folder);
  command.insert(command.begin(), own_executable().string());
  command.insert(command.end(), {"--quiet", "--force", "--threads", std::to_string(run.threads)});
  ProcessResult result = run_process(command, log, run.config.stage_limit_s);
  if (result.ok) record_key(folder, key);
  return result;
}

void run_cell(const Run& run, const Simulation& simulation, Cell& cell) {
  const fs::path folder = run.out / cell.folder, data = run.out / simulation.folder;
  fs::create_directories(folder);
  const fs::path log = folder / "log.txt";
  fs::remove(log);
  const std::string estimate = folder / "estimate";
  if (!is_current(estimate, cell.estimate_key))  // what was made of an older one goes with it
    for (const char* name : {"evaluation", "overlays"}) forget_key(folder / name);
  const auto stage = [&](const char* name, const std::string& key, const std::vector<std::string>& command) {
    const ProcessResult result = run_stage(run, folder / name, key, command, log);
    if (!result.ok) cell.failure = fmt::format("{}: {}", command[0], result.message);
    return result.ok;
  };
  std::vector<std::string> command = {
      "estimate", data / "sequence",        estimate, "--variant", cell.variant_file,
      "--seed",   std::to_string(cell.seed)};
  if (cell.perception_key)
    command.insert(command.end(), {"--perception", perception_folder(run, simulation, cell)});
  if (run.config.output) command.insert(command.end(), {"--output", to_string(*run.config.output)});
  const bool evaluated = stage("estimate", cell.estimate_key, command) &&
                         stage("evaluation", evaluation_key(cell.estimate_key),
                               {"evaluate", data / "truth", estimate, folder / "evaluation"});
  if (run.config.overlays == 0) {
    forget_key(folder / "overlays");
    fs::remove_all(folder / "overlays");  // of a call that wanted some
  } else if (evaluated) {
    stage("overlays", overlay_key(cell.estimate_key, run.config.overlays),
          {"overlay", data / "sequence", estimate, folder / "overlays", "--truth", data / "truth", "--count",
           std::to_string(run.config.overlays)});
  }
}

// Removes a sequence that nobody needs any more.
void release(const Run& run, const Simulation& simulation) {
  const bool any_failed = std::any_of(simulation.cells.begin(), simulation.cells.end(),
                                      [](const Cell& c) { return !c.failure.empty(); });
  if (any_failed || run.keep_sequences) return;  // it is needed to try again, or to see why
  forget_key(run.out / simulation.folder);
  fs::remove_all(run.out / simulation.folder);
}

void finish_cell(const Run& run, Simulation& simulation, Cell& cell) {
  if (!cell.failure.empty()) run.progress.note(fmt::format("failed: {}: {}", cell.label(), cell.failure));
  run.progress.advance();
  if (--simulation.unfinished == 0) release(run, simulation);
}

// Cells of one perception: it is made first, then the cells run side by side.
void run_cells(const Run& run, Simulation& simulation, const std::vector<Cell*>& cells) {
  const Cell& first = *cells.front();
  if (first.failure.empty() && first.perception_key) {
    const fs::path folder = perception_folder(run, simulation, first), log = folder.string() + ".log";
    const ProcessResult result =
        run_stage(run, folder, *first.perception_key,
                  {"perceive", run.out / simulation.folder / "sequence", folder, "--variant",
                   first.variant_file, "--seed", std::to_string(first.seed)},
                  log);
    for (Cell* cell : cells)
      if (!result.ok) cell->failure = "perceive: " + result.message;
  }
  for (Cell* cell : cells)
    if (cell->failure.empty())
      run.pool.add([&run, &simulation, cell] {
        run_cell(run, simulation, *cell);
        finish_cell(run, simulation, *cell);
      });
    else
      finish_cell(run, simulation, *cell);
}

fs::path routes_folder(const Run& run, const Simulation& simulation) {
  return run.out / "lidar" / simulation.scene / fmt::format("seed_{}", simulation.seed);
}

// What the report shows of a LiDAR that took the paper's way outlives the sequence.
void keep_lidar_routes(const Run& run, const Simulation& simulation, const fs::path& timing) {
  const fs::path data = run.out / simulation.folder, folder = routes_folder(run, simulation);
  const fs::path comparison = data / "truth/lidar_comparison.csv";
  if (!fs::exists(comparison)) return;
  fs::create_directories(folder);
  write_text(folder / "comparison.csv", read_text(comparison));
  write_text(folder / "errors.csv", read_text(data / "truth/lidar_errors.csv"));
  if (fs::exists(timing)) write_text(folder / "timing.csv", read_text(timing));
  record_key(folder, simulation.key);
}

bool has_kept_routes(const Run& run, const Simulation& simulation) {
  const fs::path folder = routes_folder(run, simulation);
  return is_current(folder, simulation.key) || !fs::exists(folder);  // most scenes have none
}

void run_simulation(const Run& run, Simulation& simulation) {
  std::vector<Cell*> waiting;
  for (Cell& cell : simulation.cells)
    if (!is_done(run, cell)) waiting.push_back(&cell);
  run.progress.advance(std::ssize(simulation.cells) - std::ssize(waiting));
  if (waiting.empty() && has_kept_routes(run, simulation)) return;
  std::vector<std::string> command = {"simulate", simulation.scene_file, run.out / simulation.folder,
                                      "--seed", std::to_string(simulation.seed)};
  const fs::path timing = run.out / (simulation.folder.string() + ".timing.csv");
  command.insert(command.end(), {"--timing", timing});
  if (simulation.noise_scale != 1)
    command.insert(command.end(), {"--noise-scale", fmt::format("{}", simulation.noise_scale)});
  if (run.config.frames) command.insert(command.end(), {"--frames", std::to_string(*run.config.frames)});
  const fs::path log = run.out / (simulation.folder.string() + ".log");
  fs::create_directories(log.parent_path());
  fs::remove(log);
  const ProcessResult result = run_stage(run, run.out / simulation.folder, simulation.key, command, log);
  if (result.ok) keep_lidar_routes(run, simulation, timing);
  if (waiting.empty()) return release(run, simulation);
  simulation.unfinished = static_cast<int>(waiting.size());
  std::map<std::optional<std::string>, std::vector<Cell*>> by_perception;
  for (Cell* cell : waiting) {
    by_perception[cell->perception_key].push_back(cell);
    if (!result.ok) cell->failure = "simulate: " + result.message;
  }
  for (const auto& [key, cells] : by_perception)
    run.pool.add([&run, &simulation, cells = cells] { run_cells(run, simulation, cells); });
}

int write_index(const fs::path& out, const std::vector<std::unique_ptr<Simulation>>& simulations) {
  std::string text = "scene,variant,seed,status,folder,message\n";
  int failed = 0;
  for (const auto& simulation : simulations)
    for (const Cell& cell : simulation->cells) {
      const bool ok = cell.failure.empty();
      failed += !ok;
      text += fmt::format("{},{},{},{},{},{}\n", cell.scene, cell.variant, cell.seed, ok ? "ok" : "failed",
                          cell.folder.string(), csv_quoted(cell.failure));
    }
  write_text(out / "cells.csv", text);
  return failed;
}

// Stages and reports overwrite what bears their names.
void require_results_folder(const fs::path& out, bool force) {
  require_no_dangling_link(out);
  if (!fs::exists(out)) return;
  if (!fs::is_directory(out)) throw InputError(out, "exists and is not a folder");
  if (force || fs::is_empty(out) || fs::exists(out / "bench.yaml") || fs::exists(out / "command.txt")) return;
  throw InputError(out, "is not empty and holds no results of bench; give another folder or --force");
}

std::string hardware() {
  std::string model = "unknown processor";
  for_each_line(
      "/proc/cpuinfo",
      [&](int, const std::vector<std::string_view>& fields) {
        if (fields.size() == 2 && fields[0] == "model name") model = std::string(fields[1]);
      },
      ':');
  return fmt::format("{}, {} threads\n", model, std::thread::hardware_concurrency());
}

}  // namespace

int bench(const fs::path& config_file, const fs::path& out, const BenchOptions& options) {
  const BenchConfig config = load_bench_config(config_file);
  require_results_folder(out, options.force);
  const auto simulations = plan(config);
  fs::create_directories(out);
  write_text(out / "bench.yaml", bench_yaml(config));  // at once: what is cut short can be gone on with
  const int cores = threads_to_use(0), jobs = threads_to_use(options.jobs);
  std::int64_t cells = 0;
  for (const auto& simulation : simulations) cells += std::ssize(simulation->cells);
  {
    Progress progress("bench", cells, options.quiet);
    TaskPool pool(jobs);
    const Run run{config,   out, std::max(1, cores / jobs), config.keep_sequences || options.keep_sequences,
                  progress, pool};
    for (auto it = simulations.rbegin(); it != simulations.rend(); ++it)  // the pool starts with the last
      pool.add([&run, &simulation = **it] { run_simulation(run, simulation); });
    pool.wait();
  }
  const int failed = write_index(out, simulations);
  write_text(out / "command.txt", options.command + "\n");
  write_text(out / "hardware.txt", hardware());
  write_report(out);
  return failed;
}

}  // namespace uniquadric
