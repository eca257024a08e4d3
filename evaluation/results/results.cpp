#include "evaluation/results/results.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <tuple>

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/text.h"
#include "core/sequence/tracks.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

const char* const kCellsHeader = "scene,variant,seed,status,folder,message";
const char* const kInputsHeader = "kind,name,hash";

const char* const kVariantsHeader = "name,description";

// From a column to the line's end: the last column's commas are its own.
std::string_view last_column(const std::vector<std::string_view>& fields, std::size_t column) {
  const char* const end = fields.back().data() + fields.back().size();
  return {fields[column].data(), static_cast<std::size_t>(end - fields[column].data())};
}

CellStatus parse_cell_status(const fs::path& file, int line, std::string_view text) {
  if (text == "ok") return CellStatus::ok;
  if (text == "failed") return CellStatus::failed;
  if (text == "missing") return CellStatus::missing;
  if (text == "not_applicable") return CellStatus::not_applicable;
  throw InputError(file, line,
                   fmt::format("status '{}' is none of ok, failed, missing, not_applicable", text));
}

Cell parse_cell(const fs::path& file, int line, const std::vector<std::string_view>& fields) {
  if (fields.size() < 6)
    throw InputError(file, line,
                     fmt::format("expected 6 columns ({}), found {}", kCellsHeader, fields.size()));
  Cell cell;
  cell.scene = fields[0];
  cell.variant = fields[1];
  const auto seed = parse_integer(fields[2]);
  if (!seed || *seed < 0)
    throw InputError(file, line, fmt::format("seed '{}' is no whole number", fields[2]));
  cell.seed = static_cast<std::uint64_t>(*seed);
  cell.status = parse_cell_status(file, line, fields[3]);
  cell.folder = fields[4];
  for (const std::string& name : {cell.scene, cell.variant})
    if (!is_plain_name(name)) throw InputError(file, line, fmt::format("'{}': {}", name, kPlainNameExpected));
  if (cell.variant.find(kOutputMark) != std::string::npos)
    throw InputError(file, line, fmt::format("'{}': {}", cell.variant, kOutputMarkTaken));
  if (cell.folder.is_absolute()) throw InputError(file, line, "folder is not relative to the results folder");
  if (const fs::path normal = cell.folder.lexically_normal(); !normal.empty() && *normal.begin() == "..")
    throw InputError(file, line, "folder leads out of the results folder");
  cell.message = csv_unquoted(last_column(fields, 5));
  return cell;
}

// Without blanks and line ends at its end; empty when there is no such file.
std::string read_optional(const fs::path& file) {
  if (!fs::exists(file)) return "";
  std::string text = read_text(file);
  text.erase(text.find_last_not_of(" \t\r\n") + 1);
  return text;
}

std::vector<std::string> read_inputs(const fs::path& file) {
  std::vector<std::string> inputs;
  if (!fs::exists(file)) return inputs;
  bool header = true;
  for_each_line(
      file,
      [&](int line, const std::vector<std::string_view>& fields) {
        const bool is_header = std::exchange(header, false);
        if (is_header ? fields != split(kInputsHeader, ',') : fields.size() != 3)
          throw InputError(file, line, fmt::format("expected the columns {}", kInputsHeader));
        if (!is_header) inputs.push_back(fmt::format("{} {} {}", fields[0], fields[1], fields[2]));
      },
      ',');
  return inputs;
}

std::map<std::string, std::string> read_descriptions(const fs::path& file) {
  std::map<std::string, std::string> descriptions;
  if (!fs::exists(file)) return descriptions;
  bool header = true;
  for_each_line(
      file,
      [&](int line, const std::vector<std::string_view>& fields) {
        const bool is_header = std::exchange(header, false);
        if (fields.size() < 2 || (is_header && fields != split(kVariantsHeader, ',')))
          throw InputError(file, line, fmt::format("expected the columns {}", kVariantsHeader));
        if (!is_header) descriptions.emplace(fields[0], csv_unquoted(last_column(fields, 1)));
      },
      ',');
  return descriptions;
}

// In order of the cells; a scene's runs share a seed's sequence.
std::vector<LidarRoutes> read_all_lidar_routes(const Results& results) {
  std::vector<LidarRoutes> all;
  std::set<std::pair<std::string, std::uint64_t>> seen;
  for (const Cell& cell : results.cells) {
    if (!seen.emplace(cell.scene, cell.seed).second) continue;
    const fs::path folder = results.folder / "lidar" / cell.scene / fmt::format("seed_{}", cell.seed);
    if (auto routes = read_lidar_routes(folder, cell.scene, cell.seed)) all.push_back(std::move(*routes));
  }
  return all;
}

// A variant that has an output in one run has it in all: in those that failed it failed, too.
void add_later_outputs(Results& results) {
  std::set<std::pair<std::string, std::string>> variants;  // and output
  const auto later = [](const Cell& cell, const char* output) {
    Cell result = cell;
    result.output = output;
    result.variant = cell.variant + kOutputMark + output;
    return result;
  };
  for (const Cell& cell : results.cells)
    for (const char* output : kLaterOutputs)
      if (cell.status == CellStatus::ok && fs::exists(evaluation_folder(results, later(cell, output))))
        variants.emplace(cell.variant, output);
  std::vector<Cell> cells;
  for (Cell& cell : results.cells) {
    cells.push_back(cell);
    for (const char* output : kLaterOutputs)
      if (variants.contains({cell.variant, output})) cells.push_back(later(cell, output));
  }
  results.cells = std::move(cells);
}

// All but evaluations and LiDAR.
Results read_plan(const fs::path& folder) {
  require_results_folder(folder);
  Results results;
  results.folder = folder;
  for (Cell& cell : read_cells(folder / "cells.csv"))
    (cell.status == CellStatus::not_applicable ? results.not_applicable : results.cells)
        .push_back(std::move(cell));
  results.config = read_optional(folder / "bench.yaml");
  results.command = read_optional(folder / "command.txt");
  results.hardware = read_optional(folder / "hardware.txt");
  results.program = read_optional(folder / "program.txt");
  results.inputs = read_inputs(folder / "inputs.csv");
  results.descriptions = read_descriptions(folder / "variants.csv");
  results.name = "bench";
  if (!results.config.empty())
    results.name = ConfigNode::parse(results.config, folder / "bench.yaml").get<std::string>("name", "bench");
  add_later_outputs(results);
  return results;
}

// Of more runs than `most_frames` frames.csv is read of the first seeds alone.
void read_evaluations(Results& results, std::size_t most_frames) {
  std::set<std::pair<std::string, std::string>> seen;  // scene and variant
  for (Cell& cell : results.cells) {
    if (cell.status != CellStatus::ok) continue;
    const bool is_first = seen.emplace(cell.scene, cell.variant).second;
    const bool is_read = results.cells.size() <= most_frames || (is_first && most_frames > 0);
    cell.evaluation =
        read_cell_evaluation(evaluation_folder(results, cell), is_read ? Frames::read : Frames::left);
  }
}

}  // namespace

fs::path evaluation_folder(const Results& results, const Cell& cell) {
  const fs::path folder = results.folder / cell.folder / "evaluation";
  return cell.output.empty() ? folder : folder / cell.output;
}

std::vector<Cell> read_cells(const fs::path& file) {
  std::vector<Cell> cells;
  std::set<std::tuple<std::string, std::string, std::uint64_t>> seen;
  bool header = true;
  for_each_line(
      file,
      [&](int line, const std::vector<std::string_view>& fields) {
        if (std::exchange(header, false)) {
          if (fields != split(kCellsHeader, ','))
            throw InputError(file, line, fmt::format("expected the header {}", kCellsHeader));
          return;
        }
        cells.push_back(parse_cell(file, line, fields));
        if (!seen.emplace(cells.back().scene, cells.back().variant, cells.back().seed).second)
          throw InputError(file, line, "this scene, variant and seed stand twice");
      },
      ',');
  if (header) throw InputError(file, "is empty, expected a header");
  if (cells.empty()) throw InputError(file, "has no runs");
  return cells;
}

void require_results_folder(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw InputError(folder, "is not a folder");
  if (!fs::exists(folder / "cells.csv"))
    throw InputError(folder, "is no results folder: it has no cells.csv");
}

Results read_results(const fs::path& folder, const std::optional<std::set<std::string>>& scenes,
                     std::size_t most_frames) {
  Results results = read_plan(folder);
  if (scenes)
    for (auto* const cells : {&results.cells, &results.not_applicable})
      std::erase_if(*cells, [&](const Cell& cell) { return !scenes->contains(cell.scene); });
  read_evaluations(results, most_frames);
  results.lidar = read_all_lidar_routes(results);
  return results;
}

void for_each_scene(const fs::path& folder, const std::function<void(const Results& scene)>& use) {
  Results scene = read_plan(folder);
  std::vector<std::vector<Cell>> by_scene;
  std::map<std::string, std::size_t> places;
  for (auto* const cells : {&scene.cells, &scene.not_applicable})
    for (Cell& cell : std::exchange(*cells, {})) {
      const auto [place, is_new] = places.try_emplace(cell.scene, by_scene.size());
      if (is_new) by_scene.emplace_back();
      by_scene[place->second].push_back(std::move(cell));
    }
  for (std::vector<Cell>& cells : by_scene) {
    scene.cells.clear(), scene.not_applicable.clear();
    for (Cell& cell : cells)
      (cell.status == CellStatus::not_applicable ? scene.not_applicable : scene.cells)
          .push_back(std::move(cell));
    cells = {};
    read_evaluations(scene, 0);
    use(scene);
  }
}

void add_distinct(std::vector<std::string>& list, const std::string& value) {
  if (std::find(list.begin(), list.end(), value) == list.end()) list.push_back(value);
}

std::vector<std::string> scenes_of(const Results& results) {
  std::vector<std::string> scenes;
  for (const Cell& cell : results.cells) add_distinct(scenes, cell.scene);
  return scenes;
}

std::vector<std::string> variants_of(const Results& results, const std::string& scene) {
  std::vector<std::string> variants;
  for (const Cell& cell : results.cells)
    if (cell.scene == scene) add_distinct(variants, cell.variant);
  return variants;
}

std::vector<std::string> causal_variants_of(const Results& results) {
  std::vector<std::string> variants;
  for (const Cell& cell : results.cells)
    if (cell.output.empty()) add_distinct(variants, cell.variant);
  return variants;
}

bool is_object(const std::string& subject) {
  return subject != "camera" && subject != "all";
}

std::vector<std::string> subjects_of(const Results& results, const std::string& scene) {
  std::vector<std::string> subjects;
  for (const Cell& cell : results.cells)
    if (cell.scene == scene && cell.evaluation)
      for (const SubjectFigures& figures : cell.evaluation->subjects) add_distinct(subjects, figures.subject);
  std::stable_partition(subjects.begin(), subjects.end(), is_object);
  return subjects;
}

const SubjectFigures* find_subject(const Cell& cell, const std::string& subject) {
  if (!cell.evaluation) return nullptr;
  for (const SubjectFigures& figures : cell.evaluation->subjects)
    if (figures.subject == subject) return &figures;
  return nullptr;
}

}  // namespace uniquadric
