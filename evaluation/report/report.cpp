#include "evaluation/report/report.h"

#include "core/base/error.h"
#include "core/base/files.h"
#include "evaluation/report/arc_curves.h"
#include "evaluation/report/latex.h"
#include "evaluation/report/page.h"
#include "evaluation/results/scores.h"

namespace uniquadric {

void write_report(const std::filesystem::path& folder, bool latex) {
  for (const char* name : {"iou3d_by_arc.svg", "scores.csv", "report.md", "report.html"})
    if (std::filesystem::is_directory(folder / name))
      throw InputError(folder / name, "is a folder, in the way of the file of that name");
  const Results results = read_results(folder);
  const std::vector<SummaryRow> summary = summarize(results);
  const std::string html = page_html(results, summary);  // all made before the first is written
  const std::string markdown = page_markdown(results, summary);
  const std::string arcs = arc_svg(results);
  arcs.empty() ? void(std::filesystem::remove(folder / "iou3d_by_arc.svg"))
               : write_text(folder / "iou3d_by_arc.svg", arcs);
  write_text(folder / "scores.csv", scores_csv(scores(results)));
  write_text(folder / "report.md", markdown);
  if (latex) write_text(folder / "report.tex", latex_table(summary));
  write_text(folder / "report.html", html);
}

std::string summary_table(const std::filesystem::path& folder) {
  return summary_text(summarize(read_results(folder)));
}

}  // namespace uniquadric
