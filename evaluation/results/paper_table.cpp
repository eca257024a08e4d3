#include "evaluation/results/paper_table.h"

namespace uniquadric {
namespace {

// Table III, in its order: subway and car by LiDAR, the others by depth images.
constexpr PaperRow kRows[] = {
    {"subway_car", "subway", {4.819, 2.363, 6.215, 1.021}, {0.069, 0.397, 0.055, 0.003}},
    {"subway_car", "car", {2.414, 2.451, 3.381, 0.933}, {0.244, 0.066, 0.261, 0.012}},
    {"cube_cuboid", "cuboid", {0.651, 2.387, 0.317, 1.014}, {0.082, 0.144, 0.034, 0.018}},
    {"cube_cuboid", "cube", {0.44, 2.26, 0.411, 1.51}, {0.13, 0.247, 0.103, 0.016}},
    {"skateboard_ball", "skateboard", {1.111, 1.218, 1.173, 0.299}, {0.118, 0.117, 0.118, 0.006}},
    {"skateboard_ball", "ball", {0.248, 2.370, 1.572, 1.692}, {0.186, 0.182, 0.223, 0.017}},
};

}  // namespace

std::optional<double> PaperFigures::of(std::string_view metric) const {
  if (metric == "ape_translation_rmse_m") return ape_translation_m;
  if (metric == "ape_rotation_rmse_rad") return ape_rotation_rad;
  if (metric == "rpe_translation_rmse_m") return rpe_translation_m;
  if (metric == "rpe_rotation_rmse_rad") return rpe_rotation_rad;
  return std::nullopt;
}

std::vector<const Metric*> paper_metrics() {
  std::vector<const Metric*> metrics;
  for (const Metric& metric : all_metrics())
    if (kRows[0].baseline.of(metric.name)) metrics.push_back(&metric);
  return metrics;
}

std::span<const PaperRow> paper_rows() {
  return kRows;
}

std::optional<PaperRow> paper_row(std::string_view scene, std::string_view object) {
  for (const PaperRow& row : kRows)
    if (scene == row.scene && object == row.object) return row;
  return std::nullopt;
}

}  // namespace uniquadric
