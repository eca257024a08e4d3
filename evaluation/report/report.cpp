#include "evaluation/report/report.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/text.h"
#include "evaluation/report/arc_curves.h"
#include "evaluation/report/figures.h"
#include "evaluation/report/latex.h"
#include "evaluation/report/page.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

// The names of the files that this program put into figures/: it deletes no other.
constexpr const char* kFigureList = "figures.txt";

void remove_figures(const fs::path& folder) {
  if (!fs::exists(folder / kFigureList)) return;
  const std::string list = read_text(folder / kFigureList);
  for (const auto name : split(list, '\n'))
    if (is_plain_name(name)) fs::remove(folder / name);
}

void write_figures(const std::vector<NamedPicture>& figures, const fs::path& folder) {
  fs::create_directories(folder);
  remove_figures(folder);  // of an earlier call
  std::string list;
  for (const NamedPicture& figure : figures) {
    write_text(folder / (figure.name + ".svg"), picture_svg(figure.picture));
    write_text(folder / (figure.name + ".pdf"), picture_pdf(figure.picture));
    list += figure.name + ".svg\n" + figure.name + ".pdf\n";
  }
  write_text(folder / kFigureList, list);
}

}  // namespace

void write_report(const fs::path& folder, ReportExtras extras) {
  require_results_folder(folder);
  for (const char* name : {"iou3d_by_arc.svg", "scores.csv", "report.md", "report.tex", "report.html"})
    if (fs::is_directory(folder / name))
      throw InputError(folder / name, "is a folder, in the way of the file of that name");
  if (fs::exists(folder / "figures") && !fs::is_directory(folder / "figures"))
    throw InputError(folder / "figures", "is a file, in the way of the folder of that name");
  // what an earlier call made must not stay behind with old figures
  extras.latex = extras.latex || fs::exists(folder / "report.tex");
  extras.figures = extras.figures || fs::exists(folder / "figures" / kFigureList);
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
  arcs.empty() ? void(fs::remove(folder / "iou3d_by_arc.svg"))
               : write_text(folder / "iou3d_by_arc.svg", arcs);
  scores.keep();
  write_text(folder / "report.md", markdown);
  if (extras.latex) write_text(folder / "report.tex", latex_table(summary));
  write_text(folder / "report.html", html);
}

std::string summary_table(const fs::path& folder) {
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
