#include "evaluation/report/page.h"

#include <algorithm>
#include <cassert>

#include "evaluation/report/arc_curves.h"
#include "evaluation/report/page_assets.h"
#include "evaluation/results/markup.h"

namespace uniquadric {
namespace {

// A template with its {{name}} filled in, in one pass: what is filled in is never searched.
std::string fill(std::string_view text, const std::vector<std::pair<std::string, std::string>>& values) {
  std::string result;
  while (true) {
    const std::size_t open = text.find("{{"), close = text.find("}}", open);
    if (open == text.npos || close == text.npos) break;
    const auto name = text.substr(open + 2, close - open - 2);
    const auto found =
        std::find_if(values.begin(), values.end(), [&](const auto& v) { return v.first == name; });
    assert(found != values.end());
    result.append(text.substr(0, open)).append(found->second);
    text.remove_prefix(close + 2);
  }
  return result.append(text);
}

// JSON inside a script element must not end it.
std::string inside_script(std::string json) {
  for (std::size_t at = 0; (at = json.find('<', at)) != json.npos;) json.replace(at, 1, "\\u003c");
  return json;
}

// The section with the curves over arcs; empty when there are none.
std::string arc_section(const std::string& plots) {
  if (plots.empty()) return "";
  return "<section id=\"arcs\">\n    <h2>IoU of ellipsoids against the arc of views</h2>\n    <p>How much "
         "of an object's size and place is known by how much of it was seen. The arc is the largest angle "
         "between two directions from the object to the camera so far, in the true object's own frame. "
         "Frames of a seed are averaged over 5 degrees. "
         "Lines: medians over seeds, bands: from the least to the greatest; dashed: 40 degrees. "
         "The same as a file beside this page: <a href=\"iou3d_by_arc.svg\">iou3d_by_arc.svg</a>.</p>\n    " +
         plots + "\n  </section>";
}

}  // namespace

std::string page_html(const Results& results, const std::vector<SummaryRow>& summary,
                      const Overview& overview, const PageOptions& options) {
  std::string scripts;
  for (const char* name :
       {"data.js", "verdict.js", "table.js", "ratios.js", "ablation.js", "charts.js", "lidar.js", "times.js",
        "frames.js", "space.js", "solids.js", "film.js", "paint3d.js", "view3d.js", "orbit.js", "main.js"})
    scripts += page_asset(name);
  const std::string arcs = arc_section(arc_html(results));
  return fill(page_asset("page.html"),
              {{"title", escaped(results.name)},
               {"arcs_link", arcs.empty() ? "" : "<a href=\"#arcs\">Arc of views</a>"},
               {"arcs", arcs},
               {"style", std::string(page_asset("page.css"))},
               {"data", inside_script(page_data(results, summary, overview, options))},
               {"images", inside_script(page_images(results, options))},
               {"motion", inside_script(page_motion(results, options))},
               {"scenery", inside_script(page_scenery(results, options))},
               {"three_js", std::string(page_asset("three.min.js"))},
               {"chart_js", std::string(page_asset("chart.min.js"))},
               {"script", scripts}});
}

std::vector<std::string> alignments_of(const Results& results) {
  std::vector<std::string> list;
  for (const Cell& cell : results.cells) {
    if (!cell.evaluation || cell.evaluation->alignment.empty()) continue;
    const std::string entry = cell.variant + ": " + cell.evaluation->alignment;
    if (std::find(list.begin(), list.end(), entry) == list.end()) list.push_back(entry);
  }
  return list;
}

std::vector<std::string> programs_of(const Results& results) {
  std::vector<std::string> programs;
  for (const Cell& cell : results.cells)
    if (cell.evaluation && !cell.evaluation->program.empty() &&
        std::find(programs.begin(), programs.end(), cell.evaluation->program) == programs.end())
      programs.push_back(cell.evaluation->program);
  return programs;
}

std::vector<std::uint64_t> seeds_of(const Results& results) {
  std::vector<std::uint64_t> seeds;
  for (const Cell& cell : results.cells)
    if (std::find(seeds.begin(), seeds.end(), cell.seed) == seeds.end()) seeds.push_back(cell.seed);
  return seeds;
}

}  // namespace uniquadric
