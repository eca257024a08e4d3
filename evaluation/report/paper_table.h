#pragma once

#include <optional>
#include <span>
#include <string_view>

namespace uniquadric {

/// A row of Table III of UniQuadric (arXiv 2309.17036), "Performance comparison in synthesized dataset":
/// translations in metres, rotations taken as radians (the paper prints no unit; its largest, 2.451, is below
/// pi).
struct PaperFigures {
  double ape_translation_m, ape_rotation_rad, rpe_translation_m, rpe_rotation_rad;

  /// The figure of a metric of scores.csv; nothing for metrics the table has not.
  std::optional<double> of(std::string_view metric) const;
};
struct PaperRow {
  const char* object;  ///< in lower case, as in scores.csv
  PaperFigures single_frame_obb, proposed;
};

std::span<const PaperRow> paper_rows();
/// The row of an object's name; nothing for objects the paper has not.
std::optional<PaperRow> paper_row(std::string_view object);

}  // namespace uniquadric
