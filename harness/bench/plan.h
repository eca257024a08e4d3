#pragma once

#include <filesystem>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "harness/bench/config.h"

namespace uniquadric {

/// A call of a subcommand of this program that makes a folder.
struct BenchStage {
  std::filesystem::path folder;               ///< that it makes; its key stands in FOLDER.key
  std::string key;                            ///< hash of all that the result depends on (keys.h)
  std::vector<std::string> command;           ///< subcommand and arguments, but for --threads
  std::vector<std::filesystem::path> inputs;  ///< folders of the stages that it needs
  std::filesystem::path log;
};

/// One (scene, variant, seed).
struct BenchCell {
  std::size_t variant = 0;                ///< of the configuration's
  bool is_external = false;               ///< the variant is a program of somebody else
  std::optional<std::size_t> perception;  ///< of the simulation's; nothing: it runs joined with the back end
  std::string estimate_key;
  std::string not_applicable;  ///< why the variant cannot run on that sequence; empty: it can
  bool is_missing = false;     ///< there is no result, and nothing says why
  std::string failure;         ///< why it failed; empty: it did not
};

/// What cells whose variants agree in their perception share.
struct SharedPerception {
  std::string key;
  std::size_t variant;  ///< one of them
};

/// One (scene, seed) with the cells that read its sequence.
struct BenchSimulation {
  std::size_t scene = 0;  ///< of the configuration's
  std::uint64_t seed = 0;
  std::string key;
  std::filesystem::path sequence, truth;  ///< folders; no truth: nobody knows it
  bool has_images = true;
  bool has_routes = false;  ///< a LiDAR that takes the paper's way, of which the report shows something
  std::vector<SharedPerception> perceptions;
  std::vector<BenchCell> cells;
};

/// A file that the results come from.
struct BenchInput {
  const char* kind;  ///< bench, scene, recording or variant
  std::string name;
  std::string hash;  ///< XXH64 of the file, or a hash that covers what it reads and what the bench sets
};

/// A bench taken apart, for results in `out`.
struct BenchPlan {
  BenchConfig config;
  std::filesystem::path out;
  std::vector<BenchSimulation> simulations;
  std::vector<BenchInput> made_from;

  std::filesystem::path cell_folder(const BenchSimulation& simulation,
                                    const BenchCell& cell) const;  ///< relative to `out`
  std::filesystem::path perceptions_folder(const BenchSimulation& simulation) const;
  std::filesystem::path routes_folder(const BenchSimulation& simulation) const;
  std::string label(const BenchSimulation& simulation, const BenchCell& cell) const;

  /// Nothing for a recording, which is there.
  std::optional<BenchStage> simulate(const BenchSimulation& simulation) const;
  BenchStage perceive(const BenchSimulation& simulation, std::size_t perception) const;
  BenchStage estimate(const BenchSimulation& simulation, const BenchCell& cell) const;
  /// What the report shows of a scene, of its first seed alone; nothing where it shows no pictures.
  std::optional<BenchStage> scenery(const BenchSimulation& simulation) const;
  std::string color(std::size_t variant) const;  ///< in the report's light colours: "#0072b2"
  BenchStage overlay(const BenchSimulation& simulation, const BenchCell& cell) const;
  /// One after the other: estimate, evaluate, and overlay where the configuration wants some; none of a cell
  /// that is not applicable.
  std::vector<BenchStage> stages(const BenchSimulation& simulation, const BenchCell& cell) const;
};

/// Throws InputError for a variant that cannot be read, or has not what the bench sets of it.
void check_variants(const BenchConfig& config);

/// Throws InputError for a bad configuration, scene or variant. Unless `quiet`, says how far it is where that
/// takes seconds.
BenchPlan plan_bench(const std::filesystem::path& bench_file, const std::filesystem::path& out, bool quiet);

/// Writes the scenes that are drawn from families to where the plan's commands look for them.
void write_scenes(const BenchPlan& plan);

/// The plan as JSON lines, a stage each, inputs before what is made of them (docs/cluster.md).
void print_plan(const BenchPlan& plan, const std::filesystem::path& bench_file, std::ostream& out);

}  // namespace uniquadric
