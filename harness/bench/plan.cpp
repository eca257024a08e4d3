#include "harness/bench/plan.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>
#include <ostream>

#include "core/base/hash.h"
#include "harness/bench/keys.h"
#include "harness/external/external_variant.h"
#include "simulator/lidar_files.h"
#include "simulator/scene/noise_scale.h"
#include "simulator/scene/scene.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using nlohmann::ordered_json;

// A variant of ours, or a program of somebody else.
struct PlannedVariant {
  std::optional<Variant> own;
  std::optional<ExternalVariant> external;
  std::string yaml;  // that the estimate depends on
};

PlannedVariant load_planned(const BenchConfig& config, const BenchItem& item) {
  PlannedVariant planned;
  if (is_external(item.path)) {
    planned.external = load_external_variant(item.path);
    planned.yaml = external_yaml(*planned.external);
  } else {
    planned.own = load_variant(item.path);
    planned.own->output = config.output.value_or(planned.own->output);
    planned.yaml = variant_yaml(*planned.own);
  }
  return planned;
}

std::vector<PlannedVariant> load_variants(const BenchConfig& config) {
  std::vector<PlannedVariant> variants;
  for (const BenchItem& item : config.variants) variants.push_back(load_planned(config, item));
  return variants;
}

// Of the sequence that will be simulated.
std::vector<std::string> sensors_of(const Scene& scene) {
  std::vector<std::string> sensors = {"rgb", "masks"};
  if (scene.depth) sensors.push_back("depth");
  if (scene.lidar) sensors.push_back("lidar");
  if (scene.imu) sensors.push_back("imu");
  if (scene.given_camera) sensors.push_back("given_camera");
  return sensors;
}

// Why a variant cannot run where these sensors are; empty: it can, or that is found out when it runs.
std::string fault_of(const PlannedVariant& variant, const std::vector<std::string>& sensors) {
  if (!variant.external) return "";
  const auto missing = missing_sensors(variant.external->sensors, sensors);
  return missing.empty() ? "" : fmt::format("the sequence has no {}", fmt::join(missing, ", "));
}

// The index of the perception that the variant shares with others, which may be a new one.
std::optional<std::size_t> share_perception(BenchSimulation& simulation, const Variant& variant,
                                            std::size_t index) {
  if (variant.feedback == Feedback::backend) return std::nullopt;
  const std::string key = perception_key(simulation.key, perception_yaml(variant), simulation.seed);
  auto& all = simulation.perceptions;
  const auto found = std::find_if(all.begin(), all.end(), [&](const auto& p) { return p.key == key; });
  const auto position = static_cast<std::size_t>(found - all.begin());
  if (found == all.end()) all.push_back({key, index});
  return position;
}

BenchCell plan_cell(BenchSimulation& simulation, const PlannedVariant& variant, std::size_t index,
                    const std::vector<std::string>& sensors) {
  BenchCell cell;
  cell.variant = index;
  cell.is_external = variant.external.has_value();
  cell.estimate_key = estimate_key(simulation.key, variant.yaml, simulation.seed);
  cell.not_applicable = fault_of(variant, sensors);
  if (variant.own) cell.perception = share_perception(simulation, *variant.own, index);
  return cell;
}

bool takes_the_papers_way(const Scene& scene) {
  const auto rig = lidar_of(scene);
  return rig && rig->method == LidarMethod::depth_octree;
}

fs::path simulation_folder(const BenchPlan& plan, const BenchSimulation& simulation) {
  return plan.out / "simulations" / plan.config.scenes[simulation.scene].name /
         fmt::format("seed_{}", simulation.seed);
}

BenchStage stage(const fs::path& folder, const std::string& key, std::vector<std::string> command,
                 std::vector<fs::path> inputs, const fs::path& log) {
  command.insert(command.end(), {"--quiet", "--force", "--key", key});
  return {folder, key, std::move(command), std::move(inputs), log};
}

fs::path with_suffix(const fs::path& folder, const char* suffix) {
  return folder.string() + suffix;
}

ordered_json strings(const std::vector<fs::path>& paths) {
  ordered_json result = ordered_json::array();
  for (const auto& path : paths) result.push_back(path.string());
  return result;
}

}  // namespace

fs::path BenchPlan::cell_folder(const BenchSimulation& simulation, const BenchCell& cell) const {
  return fs::path("cells") / config.scenes[simulation.scene].name / config.variants[cell.variant].name /
         fmt::format("seed_{}", simulation.seed);
}

fs::path BenchPlan::perceptions_folder(const BenchSimulation& simulation) const {
  return out / "perceptions" / config.scenes[simulation.scene].name / fmt::format("seed_{}", simulation.seed);
}

fs::path BenchPlan::routes_folder(const BenchSimulation& simulation) const {
  return out / "lidar" / config.scenes[simulation.scene].name / fmt::format("seed_{}", simulation.seed);
}

std::string BenchPlan::label(const BenchSimulation& simulation, const BenchCell& cell) const {
  return fmt::format("{} / {} / seed {}", config.scenes[simulation.scene].name,
                     config.variants[cell.variant].name, simulation.seed);
}

BenchStage BenchPlan::simulate(const BenchSimulation& simulation) const {
  const BenchScene& scene = config.scenes[simulation.scene];
  const fs::path folder = simulation_folder(*this, simulation);
  std::vector<std::string> command = {"simulate",
                                      scene.path,
                                      folder,
                                      "--seed",
                                      std::to_string(simulation.seed),
                                      "--timing",
                                      with_suffix(folder, ".timing.csv")};
  if (scene.noise_scale != 1)
    command.insert(command.end(), {"--noise-scale", fmt::format("{}", scene.noise_scale)});
  if (config.frames) command.insert(command.end(), {"--frames", std::to_string(*config.frames)});
  if (simulation.has_routes) command.insert(command.end(), {"--routes", routes_folder(simulation)});
  return stage(folder, simulation.key, std::move(command), {}, with_suffix(folder, ".log"));
}

BenchStage BenchPlan::perceive(const BenchSimulation& simulation, std::size_t perception) const {
  const SharedPerception& shared = simulation.perceptions[perception];
  const fs::path data = simulation_folder(*this, simulation);
  const fs::path folder = perceptions_folder(simulation) / shared.key;
  return stage(folder, shared.key,
               {"perceive", data / "sequence", folder, "--variant", config.variants[shared.variant].path,
                "--seed", std::to_string(simulation.seed)},
               {data}, with_suffix(folder, ".log"));
}

std::vector<BenchStage> BenchPlan::stages(const BenchSimulation& simulation, const BenchCell& cell) const {
  if (!cell.not_applicable.empty()) return {};
  const fs::path folder = out / cell_folder(simulation, cell), log = folder / "log.txt";
  const fs::path data = simulation_folder(*this, simulation), estimate = folder / "estimate",
                 evaluation = folder / "evaluation", overlays = folder / "overlays";
  std::vector<std::string> command = {"estimate",
                                      data / "sequence",
                                      estimate,
                                      "--variant",
                                      config.variants[cell.variant].path,
                                      "--seed",
                                      std::to_string(simulation.seed)};
  std::vector<fs::path> inputs = {data};
  if (cell.perception) {
    inputs.push_back(perceive(simulation, *cell.perception).folder);
    command.insert(command.end(), {"--perception", inputs.back()});
  }
  if (config.output && !cell.is_external)
    command.insert(command.end(), {"--output", to_string(*config.output)});
  std::vector<BenchStage> stages = {
      stage(estimate, cell.estimate_key, std::move(command), std::move(inputs), log),
      stage(evaluation, evaluation_key(cell.estimate_key), {"evaluate", data / "truth", estimate, evaluation},
            {data, estimate}, log)};
  if (config.overlays > 0)
    stages.push_back(stage(overlays, overlay_key(cell.estimate_key, config.overlays),
                           {"overlay", data / "sequence", estimate, overlays, "--truth", data / "truth",
                            "--count", std::to_string(config.overlays)},
                           {data, estimate}, log));
  return stages;
}

BenchPlan plan_bench(const fs::path& bench_file, const fs::path& out) {
  BenchPlan plan{load_bench_config(bench_file), out, {}, {}};
  const BenchConfig& config = plan.config;
  const std::vector<PlannedVariant> variants = load_variants(config);
  plan.made_from.push_back({"bench", config.name, hex(hash_file(bench_file))});
  for (const BenchItem& variant : config.variants)
    plan.made_from.push_back({"variant", variant.name, hex(hash_file(variant.path))});
  for (std::size_t s = 0; s < config.scenes.size(); ++s) {
    Scene scene = load_scene(config.scenes[s].path);
    scale_noise(scene, config.scenes[s].noise_scale);
    plan.made_from.push_back({"scene", config.scenes[s].name, scene.hash});
    const bool has_routes = takes_the_papers_way(scene);
    for (const auto seed : config.scenes[s].seeds) {
      BenchSimulation simulation{s,          seed, simulation_key(scene.hash, seed, config.frames),
                                 has_routes, {},   {}};
      for (std::size_t v = 0; v < variants.size(); ++v)
        simulation.cells.push_back(plan_cell(simulation, variants[v], v, sensors_of(scene)));
      plan.simulations.push_back(std::move(simulation));
    }
  }
  return plan;
}

void print_plan(const BenchPlan& plan, const fs::path& bench_file, std::ostream& out) {
  const auto print = [&](const BenchStage& stage, bool is_kept) {
    out << ordered_json{{"stage", stage.command.front()},
                        {"folder", stage.folder.string()},
                        {"key", stage.key},
                        {"inputs", strings(stage.inputs)},
                        {"command", stage.command},
                        {"log", stage.log.string()},
                        {"limit_s", plan.config.stage_limit_s},
                        {"keep", is_kept}}
        << '\n';
  };
  for (const BenchSimulation& simulation : plan.simulations) {
    print(plan.simulate(simulation), plan.config.keep_sequences);
    for (std::size_t i = 0; i < simulation.perceptions.size(); ++i)
      print(plan.perceive(simulation, i), plan.config.keep_sequences);
    for (const BenchCell& cell : simulation.cells)
      for (const BenchStage& stage : plan.stages(simulation, cell)) print(stage, true);
  }
  out << ordered_json{{"stage", "report"},
                      {"folder", plan.out.string()},
                      {"command",
                       {"bench", bench_file.string(), plan.out.string(), "--collect", "--force", "--quiet"}}}
      << '\n';
}

}  // namespace uniquadric
