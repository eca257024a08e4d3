#pragma once

#include <filesystem>
#include <string>

namespace uniquadric {

/// What is written on demand.
struct ReportExtras {
  bool latex = false;    ///< report.tex: the summary as a table (booktabs)
  bool figures = false;  ///< figures/: every plot (figures_of) as SVG and as PDF
};

/// Writes `report.html` (self-contained: no network when it is looked at), `report.md`, `scores.csv` and,
/// where evaluations have arcs of views, `iou3d_by_arc.svg` into a results folder of `bench`
/// (docs/report.md). Extras that an earlier call wrote are made again. The same folder gives the same bytes.
/// Throws InputError for a folder that is no results folder, and with file and field or line for results that
/// cannot be read.
void write_report(const std::filesystem::path& results, ReportExtras extras = {});

/// The table `bench` prints: per scene, object and variant the medians over seeds, the paper's figures beside
/// where it has the object. Plain text, ends in a newline. Throws as `write_report`.
std::string summary_table(const std::filesystem::path& results);

}  // namespace uniquadric
