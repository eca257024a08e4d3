#include "evaluation/report/overview.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>

#include "evaluation/report/page.h"
#include "evaluation/results/scores.h"

namespace uniquadric {
namespace {

constexpr const char* kIous[] = {"iou3d_solid_mean", "iou3d_ellipsoid_mean"};

struct SceneDigest {
  std::string scene;
  std::size_t rows = 0;
  double iou = 0;  // of the worst object, in the mean over variants; 0 with failures
};

double iou_of(const SummaryRow& row) {
  for (const char* iou : kIous)
    if (const auto found = row.spread.find(iou); found != row.spread.end()) return found->second.median;
  return 0;
}

// Scenes without true objects are not hard.
double iou_of_scene(const std::vector<SummaryRow>& summary) {
  std::map<std::string, double> worst;  // by variant
  for (const SummaryRow& row : summary) {
    if (row.object == "camera" || (row.object == "all" && row.good > 0)) continue;
    const auto [place, is_new] = worst.emplace(row.variant, iou_of(row));
    place->second = std::min(place->second, iou_of(row));
  }
  double sum = 0;
  for (const auto& [variant, iou] : worst) sum += iou;
  return worst.empty() ? 1 : sum / static_cast<double>(worst.size());
}

// The scene's name without the number that a family's scene has at its end.
std::string family_of(const std::string& scene) {
  const std::size_t end = scene.find_last_not_of("0123456789");
  return end != std::string::npos && end + 1 < scene.size() && scene[end] == '_' ? scene.substr(0, end)
                                                                                 : scene;
}

// As many as have `most_rows` rows, one at least.
std::set<std::string> shown_scenes(std::vector<SceneDigest> digests, std::size_t most_rows) {
  std::size_t rows = 0;
  for (const SceneDigest& digest : digests) rows += digest.rows;
  std::ranges::stable_sort(digests, {}, &SceneDigest::iou);
  const std::size_t count =
      rows <= most_rows ? digests.size() : std::max<std::size_t>(1, digests.size() * most_rows / rows);
  std::set<std::string> shown;
  const std::size_t hardest = (count + 1) / 2;
  for (std::size_t i = 0; i < hardest && i < digests.size(); ++i) shown.insert(digests[i].scene);
  for (const std::size_t i : evenly_spaced(digests.size() - hardest, count - hardest))
    shown.insert(digests[hardest + i].scene);
  return shown;
}

// As many as have `most_runs` runs, one at least.
std::set<std::string> judged_scenes(const std::filesystem::path& folder, std::size_t most_runs) {
  std::vector<std::string> scenes;
  std::set<std::string> seen;
  const std::vector<Cell> cells = read_cells(folder / "cells.csv");
  for (const Cell& cell : cells)
    if (seen.insert(cell.scene).second) scenes.push_back(cell.scene);
  if (cells.size() <= most_runs) return seen;
  std::set<std::string> judged;
  for (const std::size_t i :
       evenly_spaced(scenes.size(), std::max<std::size_t>(1, scenes.size() * most_runs / cells.size())))
    judged.insert(scenes[i]);
  return judged;
}

std::vector<SummaryRow> rows_of(const OverallRows& all, const std::map<std::string, OverallRows>& families,
                                std::size_t scenes) {
  std::vector<SummaryRow> rows = all.rows("all");
  if (families.size() > 1 && families.size() < scenes)
    for (const auto& [family, of_family] : families)
      for (SummaryRow& row : of_family.rows(family)) rows.push_back(std::move(row));
  return rows;
}

}  // namespace

std::string judged_note(const Overview& overview) {
  if (overview.judged == overview.scenes) return "";
  return fmt::format(
      "The verdicts between variants are of {} of {} scenes, spread evenly over all: `uniquadric compare` "
      "judges "
      "all.",
      overview.judged, overview.scenes);
}

Overview overview_of(const std::filesystem::path& folder, std::size_t most_rows, std::size_t most_judged,
                     std::ostream& scores_file) {
  Overview overview;
  const std::set<std::string> judged = judged_scenes(folder, most_judged);
  VariantVerdicts verdicts;
  OverallRows all;
  std::map<std::string, OverallRows> families;
  std::vector<SceneDigest> digests;
  scores_file << scores_csv({});
  for_each_scene(folder, [&](const Results& scene) {
    const std::string csv = scores_csv(scores(scene));
    scores_file << csv.substr(csv.find('\n') + 1);
    const std::vector<SummaryRow> summary = summarize(scene);
    const std::string& name = (scene.cells.empty() ? scene.not_applicable : scene.cells).front().scene;
    if (judged.contains(name)) verdicts.add(scene);
    all.add(summary);
    families[family_of(name)].add(summary);
    digests.push_back({name, std::max<std::size_t>(1, summary.size()), iou_of_scene(summary)});
    std::set<std::string> objects;
    for (const SummaryRow& row : summary)
      if (is_object(row.object)) objects.insert(row.object);
    overview.objects += objects.size();
    for (const Cell& cell : scene.cells) {
      if (!cell.output.empty()) continue;
      ++overview.runs;
      if (cell.status == CellStatus::ok) continue;
      ++overview.failed;
      digests.back().iou = 0;
    }
  });
  overview.scenes = digests.size();
  overview.judged = judged.size();
  overview.shown = shown_scenes(digests, most_rows);
  overview.verdicts = verdicts.verdicts();
  if (!overview.shows_all()) overview.rows = rows_of(all, families, digests.size());
  return overview;
}

}  // namespace uniquadric
