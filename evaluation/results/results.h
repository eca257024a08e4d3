#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "evaluation/results/lidar_routes.h"
#include "evaluation/size_steadiness.h"

namespace uniquadric {

/// Figures of one subject of one run: an object, `camera` for the ego, or `all`.
struct SubjectFigures {
  std::string subject;                  ///< name in lower case, as in scores.csv
  std::map<std::string, double> value;  ///< by metric name; absent where the evaluation has none
};

/// One object's rows of frames.csv. All columns are as long as `stamps_ns`.
struct ObjectSeries {
  std::string subject;
  std::vector<std::int64_t> frames, stamps_ns;
  std::map<std::string, std::vector<std::optional<double>>> columns;  ///< by header name, units in it
  std::int64_t id = 0;                                                ///< of the true object
};

/// What `evaluate` wrote for one run.
struct CellEvaluation {
  std::string program;                     ///< that evaluated, with version; empty where absent
  std::string alignment;                   ///< of the estimate's world; empty where absent
  std::string isolation;                   ///< of another program's run: bubblewrap or none; empty: ours
  bool camera_given = false;               ///< the camera's poses were given to the estimator, not estimated
  std::vector<SubjectFigures> subjects;    ///< objects in their order, then `camera`, then `all`
  std::vector<SizeSteadiness> sizes;       ///< of estimated objects, where no true one is known
  std::vector<ObjectSeries> series;        ///< objects in order of their ids; none where they were not read
  std::map<std::string, double> stage_ms;  ///< a frame, by stage; `frame` is all of them
};

enum class CellStatus { ok, failed, missing, not_applicable };

/// Between a variant's name and that of one of its later outputs; in no variant's own name.
inline constexpr char kOutputMark = '@';
inline constexpr const char* kOutputMarkTaken = "an @ in a variant's name marks an output";

/// One (scene, variant, seed) of a bench, or a later output of one (kLaterOutputs), whose variant is named
/// VARIANT@OUTPUT.
struct Cell {
  std::string scene, variant;
  std::uint64_t seed = 0;
  CellStatus status = CellStatus::missing;
  std::filesystem::path folder;              ///< relative to the results folder
  std::string message;                       ///< why it failed
  std::optional<CellEvaluation> evaluation;  ///< of cells that are ok
  std::string output{};                      ///< empty: what was known at each frame
};

/// A results folder (docs/report.md).
struct Results {
  std::filesystem::path folder;
  std::string name;                       ///< of the bench
  std::string config, command, hardware;  ///< bench.yaml, command.txt, hardware.txt; empty where absent
  std::string program;                    ///< program.txt: version and commit; empty where absent
  std::vector<std::string> inputs;        ///< inputs.csv: "scene cube_cuboid 0123456789abcdef"
  std::map<std::string, std::string> descriptions;  ///< variants.csv: what a variant is, by its name
  std::vector<Cell> cells;                          ///< in order of cells.csv, later outputs behind their own
  std::vector<Cell> not_applicable;  ///< the same of variants that cannot run on their sequence
  std::vector<LidarRoutes> lidar;    ///< of scenes whose LiDAR took the paper's way, a (scene, seed) each
};

/// Throws InputError for what is no folder and for one without cells.csv.
void require_results_folder(const std::filesystem::path& folder);

/// Reads a results folder with all its evaluations, or with those of some scenes; of more runs than
/// `most_frames` the series of the first seeds alone. Throws InputError: not a
/// results folder, a line of cells.csv or frames.csv, a field of evaluation.json.
Results read_results(const std::filesystem::path& folder,
                     const std::optional<std::set<std::string>>& scenes = std::nullopt,
                     std::size_t most_frames = std::numeric_limits<std::size_t>::max());

/// Reads a results folder one scene after the other, so that no more than one is in memory, and calls `use`
/// with each: all of the folder's but `lidar` and the objects' series. Throws as read_results.
void for_each_scene(const std::filesystem::path& folder,
                    const std::function<void(const Results& scene)>& use);

/// Reads cells.csv, without any evaluation. Throws InputError with file and line.
std::vector<Cell> read_cells(const std::filesystem::path& file);

enum class Frames { read, left };

/// Reads one `evaluation` folder: evaluation.json and, unless they are left, frames.csv. Throws InputError.
CellEvaluation read_cell_evaluation(const std::filesystem::path& folder, Frames frames = Frames::read);

/// Where a cell's evaluation is.
std::filesystem::path evaluation_folder(const Results& results, const Cell& cell);

/// Appends a value that the list has not.
void add_distinct(std::vector<std::string>& list, const std::string& value);

/// Distinct values in order of their first appearance.
std::vector<std::string> scenes_of(const Results& results);
std::vector<std::string> variants_of(const Results& results, const std::string& scene);
/// Of all scenes, without later outputs.
std::vector<std::string> causal_variants_of(const Results& results);
/// Subjects of a scene over all its runs: objects first, then `camera` and `all`.
std::vector<std::string> subjects_of(const Results& results, const std::string& scene);

/// Whether a subject is an object, and not `camera` or `all`.
bool is_object(const std::string& subject);

/// The figures of a subject in a run; null where the run has none.
const SubjectFigures* find_subject(const Cell& cell, const std::string& subject);

}  // namespace uniquadric
