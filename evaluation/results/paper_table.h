#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "evaluation/results/metrics.h"

namespace uniquadric {

/// Figures of Table III of UniQuadric (arXiv 2309.17036, Sec. VI-C), "Performance comparison in synthesized
/// dataset": translations in metres, rotations taken as radians (the paper prints no unit; its
/// largest, 2.451, is below pi).
struct PaperFigures {
  double ape_translation_m, ape_rotation_rad, rpe_translation_m, rpe_rotation_rad;

  /// The figure of a metric of scores.csv; nothing for metrics the table has not.
  std::optional<double> of(std::string_view metric) const;
};
/// A row of the table, and the scene made after the paper's sequence.
struct PaperRow {
  const char* scene;
  const char* object;       ///< in lower case, as in scores.csv
  PaperFigures baseline;    ///< its columns "Single Frame OBB"
  PaperFigures uniquadric;  ///< its columns "Proposed Approach"
};

/// What tables call the two systems.
inline constexpr const char* kPaperBaseline = "paper, single-frame baseline";
inline constexpr const char* kPaperUniquadric = "paper, UniQuadric";

/// The metrics that the table has, in order.
std::vector<const Metric*> paper_metrics();

std::span<const PaperRow> paper_rows();
/// The row of an object in the scene made after the paper's; nothing in any other scene
/// (`cube_cuboid_half_noise`).
std::optional<PaperRow> paper_row(std::string_view scene, std::string_view object);

}  // namespace uniquadric
