#include "evaluation/report/report.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/base/files.h"
#include "evaluation/report/arc_curves.h"
#include "evaluation/report/figures.h"
#include "evaluation/report/latex.h"
#include "evaluation/report/page.h"

namespace uniquadric {

namespace {

void write_figures(const std::vector<NamedPicture>& figures, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  for (const auto& file : std::filesystem::directory_iterator(folder))  // of an earlier call
    if (const auto ending = file.path().extension(); ending == ".svg" || ending == ".pdf")
      std::filesystem::remove(file);
  for (const NamedPicture& figure : figures) {
    write_text(folder / (figure.name + ".svg"), picture_svg(figure.picture));
    write_text(folder / (figure.name + ".pdf"), picture_pdf(figure.picture));
  }
}

}  // namespace

void write_report(const std::filesystem::path& folder, const ReportExtras& extras) {
  require_results_folder(folder);
  for (const char* name : {"iou3d_by_arc.svg", "scores.csv", "report.md", "report.tex", "report.html"})
    if (std::filesystem::is_directory(folder / name))
      throw InputError(folder / name, "is a folder, in the way of the file of that name");
  if (std::filesystem::exists(folder / "figures") && !std::filesystem::is_directory(folder / "figures"))
    throw InputError(folder / "figures", "is a file, in the way of the folder of that name");
  const PageOptions options;
  PendingText scores(folder / "scores.csv");  // large: written as it is made
  const Overview overview = overview_of(folder, options.summary_rows, options.judged_runs, scores.stream());
  const Results results = read_results(folder, overview.shown, options.series_runs);
  const std::vector<SummaryRow> summary = summarize(results);
  const std::string html =
      page_html(results, summary, overview, options);  // all made before the first is there
  const std::string markdown = page_markdown(results, summary, overview);
  const std::string arcs = arc_svg(results);
  if (extras.figures) write_figures(figures_of(results, summary), folder / "figures");
  arcs.empty() ? void(std::filesystem::remove(folder / "iou3d_by_arc.svg"))
               : write_text(folder / "iou3d_by_arc.svg", arcs);
  scores.keep();
  write_text(folder / "report.md", markdown);
  if (extras.latex) write_text(folder / "report.tex", latex_table(summary));
  write_text(folder / "report.html", html);
}

std::string summary_table(const std::filesystem::path& folder) {
  const std::size_t most_rows = PageOptions().summary_rows;
  OverallRows all;
  std::vector<SummaryRow> rows;
  std::size_t count = 0;
  for_each_scene(folder, [&](const Results& scene) {
    const std::vector<SummaryRow> summary = summarize(scene);
    all.add(summary);
    count += summary.size();
    if (count <= most_rows) rows.insert(rows.end(), summary.begin(), summary.end());
  });
  if (count <= most_rows) return summary_text(rows);
  return fmt::format("{} rows are more than a table: scores.csv has all\n", count) +
         summary_text(all.rows("all"));
}

}  // namespace uniquadric
