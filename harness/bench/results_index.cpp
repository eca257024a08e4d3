#include "harness/bench/results_index.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <sstream>
#include <thread>

#include "core/base/files.h"
#include "core/base/text.h"
#include "core/base/version.h"
#include "evaluation/report/report.h"
#include "harness/bench/keys.h"
#include "harness/bench/process.h"
#include "harness/bench/program.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

// What the program says of an error begins so.
constexpr const char* kSaid = "uniquadric: ";

// What the last of the stages that ran without making its folder said; nothing when none did.
std::string said_by(const std::vector<BenchStage>& stages) {
  for (const BenchStage& stage : stages) {
    if (is_current(stage.folder, stage.key) || !fs::exists(stage.log)) continue;
    if (const std::string line = last_line(stage.log); line.starts_with(kSaid))
      return fmt::format("{}: {}", stage.command.front(), line);
  }
  return "";
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

const char* status(const BenchCell& cell) {
  if (!cell.not_applicable.empty()) return "not_applicable";
  if (cell.is_missing) return "missing";
  return cell.failure.empty() ? "ok" : "failed";
}

std::string cells_csv(const BenchPlan& plan) {
  std::string text = "scene,variant,seed,status,folder,message\n";
  for (const BenchSimulation& simulation : plan.simulations)
    for (const BenchCell& cell : simulation.cells)
      text += fmt::format("{},{},{},{},{},{}\n", plan.config.scenes[simulation.scene].name,
                          plan.config.variants[cell.variant].name, simulation.seed, status(cell),
                          plan.cell_folder(simulation, cell).string(),
                          csv_quoted(cell.not_applicable.empty() ? cell.failure : cell.not_applicable));
  return text;
}

std::string inputs_csv(const BenchPlan& plan) {
  std::string text = "kind,name,hash\n";
  for (const BenchInput& input : plan.made_from)
    text += fmt::format("{},{},{}\n", input.kind, input.name, input.hash);
  return text;
}

// The comment that a variant's file begins with, in one line, and what the bench sets in it.
std::string description_of(const BenchVariant& variant) {
  std::istringstream file(read_text(variant.path));
  std::vector<std::string> parts;
  for (std::string line; std::getline(file, line) && line.starts_with('#');)
    if (const std::size_t first = line.find_first_not_of("# \t"); first != std::string::npos)
      parts.push_back(line.substr(first));
  for (const ConfigOverride& value : variant.set) parts.push_back(value.key + " = " + value.value);
  return fmt::format("{}", fmt::join(parts, " "));
}

std::string variants_csv(const BenchPlan& plan) {
  std::string text = "name,description\n";
  for (const BenchVariant& variant : plan.config.variants)
    text += fmt::format("{},{}\n", variant.name, csv_quoted(description_of(variant)));
  return text;
}

// Of a call that wanted some.
void remove_overlays(const BenchPlan& plan) {
  for (const BenchSimulation& simulation : plan.simulations)
    for (const BenchCell& cell : simulation.cells) {
      const fs::path overlays = plan.out / plan.cell_folder(simulation, cell) / "overlays";
      forget_key(overlays);
      fs::remove_all(overlays);
    }
}

}  // namespace

bool is_done(const BenchPlan& plan, const BenchSimulation& simulation, const BenchCell& cell) {
  const std::vector<BenchStage> stages = plan.stages(simulation, cell);
  return std::all_of(stages.begin(), stages.end(),
                     [](const BenchStage& stage) { return is_current(stage.folder, stage.key); });
}

int find_failures(BenchPlan& plan) {
  int undone = 0;
  for (BenchSimulation& simulation : plan.simulations)
    for (BenchCell& cell : simulation.cells) {
      if (is_done(plan, simulation, cell)) continue;
      ++undone;
      std::vector<BenchStage> stages = plan.stages(simulation, cell);
      if (cell.perception) stages.insert(stages.begin(), plan.perceive(simulation, *cell.perception));
      if (const auto simulate = plan.simulate(simulation)) stages.insert(stages.begin(), *simulate);
      cell.failure = said_by(stages);
      cell.is_missing = cell.failure.empty();
    }
  return undone;
}

void write_results(const BenchPlan& plan, const std::string& command) {
  if (plan.config.overlays == 0) remove_overlays(plan);
  write_text(plan.out / "cells.csv", cells_csv(plan));
  write_text(plan.out / "command.txt", command + "\n");
  write_text(plan.out / "hardware.txt", hardware());
  write_text(plan.out / "program.txt", fmt::format("{}, {}\n", kProgram, program_source()));
  write_text(plan.out / "inputs.csv", inputs_csv(plan));
  write_text(plan.out / "variants.csv", variants_csv(plan));
  write_report(plan.out);
}

}  // namespace uniquadric
