#include "harness/bench/bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <memory>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/interrupt.h"
#include "core/base/progress.h"
#include "core/base/threads.h"
#include "harness/bench/keys.h"
#include "harness/bench/plan.h"
#include "harness/bench/process.h"
#include "harness/bench/results_index.h"
#include "harness/bench/task_pool.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

// A simulation whose cells are under way.
struct Work {
  BenchSimulation& simulation;
  std::atomic<int> unfinished{0};
};

struct Run {
  const BenchPlan& plan;
  int threads;  // of each stage
  bool keep_sequences;
  Progress& progress;
  TaskPool& pool;
};

// Runs a subcommand of this program that makes a folder, unless it is there already.
ProcessResult run_stage(const Run& run, const BenchStage& stage) {
  if (is_current(stage.folder, stage.key)) return {true, ""};
  run.progress.say(fmt::format("{}: {}", stage.command.front(),
                               stage.folder.lexically_relative(run.plan.out).generic_string()));
  fs::create_directories(stage.folder.parent_path());
  std::vector<std::string> command = stage.command;
  command.insert(command.begin(), own_executable().string());
  command.insert(command.end(), {"--threads", std::to_string(run.threads)});
  return run_process(command, stage.log, run.plan.config.stage_limit_s);
}

void run_cell(const Run& run, const BenchSimulation& simulation, BenchCell& cell) {
  const std::vector<BenchStage> stages = run.plan.stages(simulation, cell);
  fs::create_directories(stages.front().log.parent_path());
  fs::remove(stages.front().log);
  if (!is_current(stages.front().folder, stages.front().key))  // what was made of an older one goes with it
    for (const BenchStage& stage : stages) forget_key(stage.folder);
  for (const BenchStage& stage : stages) {
    const ProcessResult result = run_stage(run, stage);
    if (result.ok) continue;
    cell.failure = fmt::format("{}: {}", stage.command.front(), result.message);
    return;
  }
}

// Removes a sequence that nobody needs any more, and what was perceived of it; a recording stays.
void release(const Run& run, const BenchSimulation& simulation) {
  const bool any_failed = std::any_of(simulation.cells.begin(), simulation.cells.end(),
                                      [](const BenchCell& c) { return !c.failure.empty(); });
  if (any_failed || run.keep_sequences) return;  // it is needed to try again, or to see why
  if (const auto simulate = run.plan.simulate(simulation)) {
    forget_key(simulate->folder);
    fs::remove_all(simulate->folder);
  }
  fs::remove_all(run.plan.perceptions_folder(simulation));
}

void finish_cell(const Run& run, Work& work, const BenchCell& cell) {
  if (!cell.failure.empty())
    run.progress.note(fmt::format("failed: {}: {}", run.plan.label(work.simulation, cell), cell.failure));
  run.progress.advance();
  if (--work.unfinished == 0) release(run, work.simulation);
}

// Cells of one perception: it is made first, then the cells run side by side.
void run_cells(const Run& run, const std::shared_ptr<Work>& work, const std::vector<BenchCell*>& cells) {
  const BenchCell& first = *cells.front();
  if (first.failure.empty() && first.perception) {
    const ProcessResult result = run_stage(run, run.plan.perceive(work->simulation, *first.perception));
    for (BenchCell* cell : cells)
      if (!result.ok) cell->failure = "perceive: " + result.message;
  }
  for (BenchCell* cell : cells)
    if (cell->failure.empty())
      run.pool.add([&run, work, cell] {
        run_cell(run, work->simulation, *cell);
        finish_cell(run, *work, *cell);
      });
    else
      finish_cell(run, *work, *cell);
}

// What the report shows of a LiDAR outlives the sequence, which is simulated again for it alone.
bool has_kept_routes(const Run& run, const BenchSimulation& simulation) {
  return !simulation.has_routes || is_current(run.plan.routes_folder(simulation), simulation.key);
}

// The sequence, where cells wait for it or the report lacks what it shows of the LiDAR.
ProcessResult simulate(const Run& run, const BenchSimulation& simulation, bool is_wanted) {
  const auto stage = run.plan.simulate(simulation);
  const bool has_routes = has_kept_routes(run, simulation);
  if (!stage || (!is_wanted && has_routes)) return {true, ""};
  if (!has_routes) forget_key(stage->folder);
  fs::remove(stage->log);
  return run_stage(run, *stage);
}

// The report can do without it.
void keep_scenery(const Run& run, const BenchSimulation& simulation) {
  const auto stage = run.plan.scenery(simulation);
  if (!stage || is_current(stage->folder, stage->key)) return;
  fs::remove(stage->log);
  if (const ProcessResult result = run_stage(run, *stage); !result.ok)
    run.progress.note("no scenery: " + result.message);
}

void run_simulation(const Run& run, BenchSimulation& simulation) {
  std::vector<BenchCell*> waiting;
  for (BenchCell& cell : simulation.cells)
    if (!is_done(run.plan, simulation, cell)) waiting.push_back(&cell);
  run.progress.skip(std::ssize(simulation.cells) - std::ssize(waiting));
  const ProcessResult result = simulate(run, simulation, !waiting.empty());
  if (waiting.empty()) return release(run, simulation);
  if (result.ok) keep_scenery(run, simulation);
  const auto work = std::make_shared<Work>(simulation);
  work->unfinished = static_cast<int>(waiting.size());
  std::map<std::optional<std::size_t>, std::vector<BenchCell*>> by_perception;
  for (BenchCell* cell : waiting) {
    by_perception[cell->perception].push_back(cell);
    if (!result.ok) cell->failure = "simulate: " + result.message;
  }
  for (const auto& [perception, cells] : by_perception)
    run.pool.add([&run, work, cells = cells] { run_cells(run, work, cells); });
}

void run_all(BenchPlan& plan, const BenchOptions& options) {
  const int cores = threads_to_use(0), jobs = threads_to_use(options.jobs);
  std::int64_t cells = 0;
  for (const auto& simulation : plan.simulations) cells += std::ssize(simulation.cells);
  Progress progress("bench", cells, options.quiet);
  TaskPool pool(jobs);
  const Run run{plan, std::max(1, cores / jobs), plan.config.keep_sequences || options.keep_sequences,
                progress, pool};
  for (auto it = plan.simulations.rbegin(); it != plan.simulations.rend(); ++it)  // it starts with the last
    pool.add([&run, &simulation = *it] { run_simulation(run, simulation); });
  pool.wait();
}

int count_failures(const BenchPlan& plan) {
  int failed = 0;
  for (const auto& simulation : plan.simulations)
    for (const auto& cell : simulation.cells) failed += !cell.failure.empty();
  return failed;
}

// One killed in its first moments has written none of its files whole.
bool holds_results(const fs::path& out) {
  const fs::path config = out / "bench.yaml";
  return fs::exists(config) || fs::exists(aside_of(config)) || fs::exists(out / "command.txt") ||
         fs::exists(out / "scenes");  // of --plan
}

// Stages and reports overwrite what bears their names.
void require_results_folder(const fs::path& out, bool collects) {
  require_no_dangling_link(out);
  if (!fs::exists(out)) return;
  if (!fs::is_directory(out)) throw InputError(out, "exists and is not a folder");
  const bool is_engines = collects && fs::is_directory(out / "cells");  // stages were run without bench
  if (is_engines || fs::is_empty(out) || holds_results(out)) return;
  throw InputError(out, "is not empty and holds no results of bench; give another folder");
}

}  // namespace

int bench(const fs::path& config_file, const fs::path& out, const BenchOptions& options) {
  require_results_folder(out, options.collect);
  BenchPlan plan = plan_bench(config_file, out, options.quiet);
  fs::create_directories(out);
  const FolderLock lock(out, out);
  leave_when_interrupted(
      fmt::format("what is done is kept in {}: the same command goes on with it", out.string()));
  write_text(out / "bench.yaml",
             bench_yaml(plan.config, out));  // at once: what is cut short can be gone on with
  write_scenes(plan);
  if (!options.collect) run_all(plan, options);
  const int failed = options.collect ? find_failures(plan) : count_failures(plan);
  write_results(plan, options.command);
  return failed;
}

}  // namespace uniquadric
