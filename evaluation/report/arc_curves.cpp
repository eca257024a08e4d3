#include "evaluation/report/arc_curves.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "evaluation/results/summary.h"

namespace uniquadric {
namespace {

// ours: tens up to where shapes should be known (40) and a little on, then wider
constexpr std::array kTable_deg = {0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 90.0, 120.0, 180.0};

// Of one run: mean IoU an interval; nothing of intervals without a frame.
std::vector<std::optional<double>> means_of(const ObjectSeries& series, std::span<const double> edges_deg) {
  std::vector<double> sum(edges_deg.size() - 1), count(edges_deg.size() - 1);
  const auto arcs = series.columns.find("arc_deg"), ious = series.columns.find("iou3d");
  if (arcs != series.columns.end() && ious != series.columns.end())
    for (std::size_t k = 0; k < series.frames.size(); ++k) {
      const auto &arc = arcs->second[k], &iou = ious->second[k];
      if (!arc || !iou || *arc < edges_deg.front() || *arc > edges_deg.back()) continue;
      const auto above = std::upper_bound(edges_deg.begin(), edges_deg.end() - 1, *arc) - edges_deg.begin();
      sum[static_cast<std::size_t>(above) - 1] += *iou;
      count[static_cast<std::size_t>(above) - 1] += 1;
    }
  std::vector<std::optional<double>> means(sum.size());
  for (std::size_t i = 0; i < sum.size(); ++i)
    if (count[i] > 0) means[i] = sum[i] / count[i];
  return means;
}

ArcCurve curve_of(const Results& results, const std::string& scene, const std::string& object,
                  const std::string& variant, std::span<const double> edges_deg) {
  std::vector<std::vector<double>> of_interval(edges_deg.size() - 1);
  for (const Cell& cell : results.cells) {
    if (cell.scene != scene || cell.variant != variant || !cell.evaluation) continue;
    for (const ObjectSeries& series : cell.evaluation->series) {
      if (series.subject != object) continue;
      const auto means = means_of(series, edges_deg);
      for (std::size_t i = 0; i < means.size(); ++i)
        if (means[i]) of_interval[i].push_back(*means[i]);
    }
  }
  ArcCurve curve{scene, object, variant, {}};
  for (std::size_t i = 0; i < of_interval.size(); ++i) {
    const auto& values = of_interval[i];
    if (values.empty()) continue;
    const auto [min, max] = std::minmax_element(values.begin(), values.end());
    curve.points.push_back(
        {edges_deg[i], edges_deg[i + 1], median(values), *min, *max, static_cast<int>(values.size())});
  }
  return curve;
}

std::string row(const std::vector<std::string>& fields) {
  std::string text = "|";
  for (const std::string& field : fields) text += " " + field + " |";
  return text + "\n";
}

}  // namespace

std::vector<ArcCurve> arc_curves(const Results& results, std::span<const double> edges_deg) {
  std::vector<ArcCurve> curves;
  for (const std::string& scene : scenes_of(results))
    for (const std::string& object : subjects_of(results, scene))
      for (const std::string& variant : variants_of(results, scene))
        if (ArcCurve curve = curve_of(results, scene, object, variant, edges_deg); !curve.points.empty())
          curves.push_back(std::move(curve));
  return curves;
}

std::string arc_markdown(const Results& results) {
  const std::vector<ArcCurve> curves = arc_curves(results, kTable_deg);
  if (curves.empty()) return "";
  std::vector<std::string> head = {"scene", "object", "variant"}, rule = {"---", "---", "---"};
  for (std::size_t i = 0; i + 1 < kTable_deg.size(); ++i) {
    head.push_back(fmt::format("{}-{}", kTable_deg[i], kTable_deg[i + 1]));
    rule.push_back("---:");
  }
  std::string text =
      "\n## IoU of ellipsoids against the arc of views\n"
      "Mean over the frames whose arc so far lies in an interval [deg], median over seeds. The arc is the "
      "largest "
      "angle between two directions from the object to the camera, in the true object's own frame.\n\n" +
      row(head) + row(rule);
  for (const ArcCurve& curve : curves) {
    std::vector<std::string> fields = {curve.scene, curve.object, curve.variant};
    for (std::size_t i = 0; i + 1 < kTable_deg.size(); ++i) {
      const auto point = std::find_if(curve.points.begin(), curve.points.end(),
                                      [&](const ArcPoint& p) { return p.from_deg == kTable_deg[i]; });
      fields.push_back(point == curve.points.end() ? "-" : format_figure(point->median));
    }
    text += row(fields);
  }
  return text;
}

}  // namespace uniquadric
