#include "harness/bench/plan.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <ostream>

#include "core/base/files.h"
#include "core/base/folder_hashes.h"
#include "core/base/hash.h"
#include "evaluation/report/svg_colours.h"
#include "harness/bench/keys.h"
#include "harness/bench/scene_data.h"
#include "harness/external/external_variant.h"

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

PlannedVariant load_planned(const BenchVariant& item) {
  PlannedVariant planned;
  if (is_external(item.path)) {
    planned.external = load_external_variant(item.path);
    planned.yaml = external_yaml(*planned.external);
  } else {
    planned.own = load_variant(item.path, item.set);
    planned.yaml = variant_yaml(*planned.own);
  }
  return planned;
}

std::vector<PlannedVariant> load_variants(const BenchConfig& config) {
  std::vector<PlannedVariant> variants;
  for (const BenchVariant& item : config.variants) variants.push_back(load_planned(item));
  return variants;
}

// What a variant of ours cannot do without.
std::vector<std::string> needed_sensors(const Variant& variant) {
  const PerceptionOptions& o = variant.perception;
  std::vector<std::string> sensors;
  if (o.ego == EgoSource::given) sensors = {"given_camera"};
  if (o.ego == EgoSource::rgbd) sensors = {"rgb", "depth"};
  if (o.ego == EgoSource::lidar || o.depth == DepthSource::lidar) sensors.push_back("lidar");
  if (o.ego == EgoSource::given && o.depth == DepthSource::images) sensors.push_back("depth");
  return sensors;
}

// Why a variant cannot run where these sensors are; empty: it can, or that is found out when it runs.
std::string fault_of(const PlannedVariant& variant, const std::vector<std::string>& sensors) {
  const auto missing =
      missing_sensors(variant.own ? needed_sensors(*variant.own) : variant.external->sensors, sensors);
  return missing.empty() ? "" : fmt::format("the sequence has no {}", fmt::join(missing, ", "));
}

// What an estimate depends on beside its variant; empty: no prompt.
std::string prompt_key(const std::string& prompt) {
  if (prompt.empty()) return "";
  const std::size_t colon = prompt.find(':');
  const fs::path file = prompt.substr(colon + 1);
  const std::string content = fs::is_directory(file) ? list_hashes(file) : hex(hash_file(file));
  return fmt::format("prompt: {} {} {}\n", prompt.substr(0, colon), file.filename().string(), content);
}

// The index of the perception that the variant shares with others, which may be a new one.
std::optional<std::size_t> share_perception(BenchSimulation& simulation, const Variant& variant,
                                            const std::string& prompt, std::size_t index) {
  if (variant.feedback == Feedback::backend) return std::nullopt;
  const std::string key = perception_key(simulation.key, perception_yaml(variant) + prompt, simulation.seed);
  auto& all = simulation.perceptions;
  const auto found = std::find_if(all.begin(), all.end(), [&](const auto& p) { return p.key == key; });
  const auto position = static_cast<std::size_t>(found - all.begin());
  if (found == all.end()) all.push_back({key, index});
  return position;
}

BenchCell plan_cell(BenchSimulation& simulation, const PlannedVariant& variant, std::size_t index,
                    const std::vector<std::string>& sensors, const std::string& prompt) {
  BenchCell cell;
  cell.variant = index;
  cell.is_external = variant.external.has_value();
  cell.estimate_key = estimate_key(simulation.key, variant.yaml + prompt, simulation.seed);
  cell.not_applicable = fault_of(variant, sensors);
  if (variant.own && cell.not_applicable.empty())
    cell.perception = share_perception(simulation, *variant.own, prompt, index);
  return cell;
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

BenchSimulation plan_simulation(const BenchPlan& plan, std::size_t scene, std::uint64_t seed,
                                const SceneData& data) {
  BenchSimulation simulation;
  simulation.scene = scene;
  simulation.seed = seed;
  simulation.has_routes = data.has_routes;
  simulation.has_images = std::ranges::find(data.sensors, "rgb") != data.sensors.end();
  if (plan.config.scenes[scene].is_recording) {
    simulation.key = data.hash;
    simulation.sequence = data.sequence;
    simulation.truth = data.truth;
  } else {
    const fs::path folder = simulation_folder(plan, simulation);
    simulation.key = simulation_key(data.hash, seed, plan.config.frames);
    simulation.sequence = folder / "sequence";
    simulation.truth = folder / "truth";
  }
  return simulation;
}

// A recording is there: no stage makes it.
std::vector<fs::path> made_data(const BenchPlan& plan, const BenchSimulation& simulation) {
  if (plan.config.scenes[simulation.scene].is_recording) return {};
  return {simulation_folder(plan, simulation)};
}

void add_set(const std::vector<ConfigOverride>& set, std::vector<std::string>& command) {
  for (const ConfigOverride& value : set)
    command.insert(command.end(), {"--set", value.key + '=' + value.value});
}

// Of its file, with what the bench sets in it.
std::string variant_hash(const BenchVariant& variant) {
  if (variant.set.empty()) return hex(hash_file(variant.path));
  Hash hash;
  hash.add_file(variant.path);
  for (const ConfigOverride& value : variant.set) hash.add(value.key).add(value.value);
  return hash.hex();
}

void add_prompt(const BenchScene& scene, std::vector<std::string>& command) {
  if (!scene.prompt.empty()) command.insert(command.end(), {"--prompt", scene.prompt});
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

std::optional<BenchStage> BenchPlan::simulate(const BenchSimulation& simulation) const {
  const BenchScene& scene = config.scenes[simulation.scene];
  if (scene.is_recording) return std::nullopt;
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
  add_set(scene.set, command);
  if (config.frames) command.insert(command.end(), {"--frames", std::to_string(*config.frames)});
  if (simulation.has_routes) command.insert(command.end(), {"--routes", routes_folder(simulation)});
  return stage(folder, simulation.key, std::move(command), {}, with_suffix(folder, ".log"));
}

BenchStage BenchPlan::perceive(const BenchSimulation& simulation, std::size_t perception) const {
  const SharedPerception& shared = simulation.perceptions[perception];
  const fs::path folder = perceptions_folder(simulation) / shared.key;
  std::vector<std::string> command = {"perceive",
                                      simulation.sequence,
                                      folder,
                                      "--variant",
                                      config.variants[shared.variant].path,
                                      "--seed",
                                      std::to_string(simulation.seed)};
  add_set(config.variants[shared.variant].set, command);
  add_prompt(config.scenes[simulation.scene], command);
  return stage(folder, shared.key, std::move(command), made_data(*this, simulation),
               with_suffix(folder, ".log"));
}

BenchStage BenchPlan::estimate(const BenchSimulation& simulation, const BenchCell& cell) const {
  const fs::path folder = out / cell_folder(simulation, cell);
  std::vector<std::string> command = {"estimate",
                                      simulation.sequence,
                                      folder / "estimate",
                                      "--variant",
                                      config.variants[cell.variant].path,
                                      "--seed",
                                      std::to_string(simulation.seed)};
  add_set(config.variants[cell.variant].set, command);
  std::vector<fs::path> inputs = made_data(*this, simulation);
  if (cell.perception) {
    inputs.push_back(perceive(simulation, *cell.perception).folder);
    command.insert(command.end(), {"--perception", inputs.back()});
  }
  add_prompt(config.scenes[simulation.scene], command);
  return stage(folder / "estimate", cell.estimate_key, std::move(command), std::move(inputs),
               folder / "log.txt");
}

std::optional<BenchStage> BenchPlan::scenery(const BenchSimulation& simulation) const {
  const BenchScene& scene = config.scenes[simulation.scene];
  if (config.overlays == 0 || simulation.seed != scene.seeds.front()) return std::nullopt;
  const fs::path folder = out / "scenery" / scene.name;
  std::vector<std::string> command = {"scenery", simulation.sequence, folder};
  if (!simulation.truth.empty()) command.insert(command.end(), {"--truth", simulation.truth});
  return stage(folder, scenery_key(simulation.key), std::move(command), made_data(*this, simulation),
               with_suffix(folder, ".log"));
}

// The variants' colours in the report are given in the order in which its runs come.
std::string BenchPlan::color(std::size_t variant) const {
  std::vector<std::size_t> order;
  for (const BenchSimulation& simulation : simulations)
    for (const BenchCell& cell : simulation.cells)
      if (cell.not_applicable.empty() && std::ranges::find(order, cell.variant) == order.end())
        order.push_back(cell.variant);
  const auto place = static_cast<std::size_t>(std::ranges::find(order, variant) - order.begin());
  return kLightSvg.variant[place % kLightSvg.variant.size()];
}

BenchStage BenchPlan::overlay(const BenchSimulation& simulation, const BenchCell& cell) const {
  const fs::path folder = out / cell_folder(simulation, cell), estimate = folder / "estimate";
  std::vector<std::string> command = {"overlay", simulation.sequence, estimate, folder / "overlays"};
  if (!simulation.truth.empty()) command.insert(command.end(), {"--truth", simulation.truth});
  command.insert(command.end(),
                 {"--count", std::to_string(config.overlays), "--colour", color(cell.variant)});
  std::vector<fs::path> inputs = made_data(*this, simulation);
  inputs.push_back(estimate);
  return stage(folder / "overlays", overlay_key(cell.estimate_key, config.overlays, color(cell.variant)),
               std::move(command), std::move(inputs), folder / "log.txt");
}

std::vector<BenchStage> BenchPlan::stages(const BenchSimulation& simulation, const BenchCell& cell) const {
  if (!cell.not_applicable.empty()) return {};
  std::vector<BenchStage> stages = {estimate(simulation, cell)};
  const BenchStage& estimated = stages.front();
  std::vector<fs::path> inputs = made_data(*this, simulation);
  inputs.push_back(estimated.folder);
  const fs::path& truth = simulation.truth.empty() ? simulation.sequence : simulation.truth;
  const fs::path evaluation = estimated.folder.parent_path() / "evaluation";
  const std::vector<std::string>& judging = config.scenes[simulation.scene].judging;
  std::vector<std::string> command = {"evaluate", truth, estimated.folder, evaluation};
  command.insert(command.end(), judging.begin(), judging.end());
  stages.push_back(stage(evaluation, evaluation_key(cell.estimate_key, judging), std::move(command),
                         std::move(inputs), estimated.log));
  if (config.overlays > 0 && simulation.has_images) stages.push_back(overlay(simulation, cell));
  return stages;
}

void check_variants(const BenchConfig& config) {
  load_variants(config);
}

BenchPlan plan_bench(const fs::path& bench_file, const fs::path& out, bool quiet) {
  BenchPlan plan{load_bench_config(bench_file), out, {}, {}};
  for (BenchScene& scene : plan.config.scenes)
    if (scene.drawn_from) scene.path = out / "scenes" / (scene.name + ".yaml");
  const std::vector<PlannedVariant> variants = load_variants(plan.config);
  const std::vector<SceneData> data_of_scenes = look_at_scenes(plan.config.scenes, quiet);
  const BenchConfig& config = plan.config;
  plan.made_from.push_back({"bench", config.name, hex(hash_file(bench_file))});
  for (const BenchVariant& variant : config.variants)
    plan.made_from.push_back({"variant", variant.name, variant_hash(variant)});
  for (std::size_t s = 0; s < config.scenes.size(); ++s) {
    const SceneData& data = data_of_scenes[s];
    plan.made_from.push_back({data.kind, config.scenes[s].name, data.hash});
    const std::string prompt = prompt_key(config.scenes[s].prompt);
    for (const auto seed : config.scenes[s].seeds) {
      BenchSimulation simulation = plan_simulation(plan, s, seed, data);
      for (std::size_t v = 0; v < variants.size(); ++v)
        simulation.cells.push_back(plan_cell(simulation, variants[v], v, data.sensors, prompt));
      plan.simulations.push_back(std::move(simulation));
    }
  }
  return plan;
}

void write_scenes(const BenchPlan& plan) {
  for (const BenchScene& scene : plan.config.scenes) {
    if (!scene.drawn_from) continue;
    fs::create_directories(scene.path.parent_path());
    write_text(scene.path, scene.generated);
  }
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
    if (const auto stage = plan.simulate(simulation)) print(*stage, plan.config.keep_sequences);
    for (std::size_t i = 0; i < simulation.perceptions.size(); ++i)
      print(plan.perceive(simulation, i), plan.config.keep_sequences);
    if (const auto stage = plan.scenery(simulation)) print(*stage, true);
    for (const BenchCell& cell : simulation.cells)
      for (const BenchStage& stage : plan.stages(simulation, cell)) print(stage, true);
  }
  out << ordered_json{{"stage", "report"},
                      {"folder", plan.out.string()},
                      {"command", {"bench", bench_file.string(), plan.out.string(), "--collect", "--quiet"}}}
      << '\n';
}

}  // namespace uniquadric
