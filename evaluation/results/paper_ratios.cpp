#include "evaluation/results/paper_ratios.h"

#include <algorithm>
#include <span>
#include <string_view>

namespace uniquadric {
namespace {

constexpr const char* kBaselines[] = {"single_frame_obb", "single_frame_lidar"};

bool is_baseline(const SummaryRow& row) {
  return std::find(std::begin(kBaselines), std::end(kBaselines), without_output(row.variant)) !=
         std::end(kBaselines);
}

const SummaryRow* find_variant(std::span<const SummaryRow> rows, const std::string& variant) {
  const auto found = std::find_if(rows.begin(), rows.end(), [&](const SummaryRow& row) {
    return row.variant == variant && row.good > 0;
  });
  return found == rows.end() ? nullptr : &*found;
}

// Of the same output, else causal; null where neither has a result.
const SummaryRow* find_baseline(std::span<const SummaryRow> rows, const std::string& output) {
  for (const std::string& wanted : {output, std::string()})
    for (const char* name : kBaselines)
      if (const SummaryRow* row = find_variant(rows, name + wanted)) return row;
  return nullptr;
}

PaperRatio ratio_of(const SummaryRow& row, const SummaryRow& baseline) {
  PaperRatio result{row.scene, row.object, row.variant, baseline.variant, row.runs, row.good, {}};
  for (const Metric* metric : paper_metrics()) {
    const auto own = row.spread.find(metric->name), below = baseline.spread.find(metric->name);
    if (own != row.spread.end() && below != baseline.spread.end() && below->second.median > 0)
      result.ratio[metric->name] = own->second.median / below->second.median;
  }
  return result;
}

PaperRatio paper_ratio(const SummaryRow& row) {
  PaperRatio result{row.scene, row.object, kPaperUniquadric, kPaperBaseline, 0, 0, {}};
  for (const Metric* metric : paper_metrics())
    result.ratio[metric->name] =
        *row.paper->uniquadric.of(metric->name) / *row.paper->baseline.of(metric->name);
  return result;
}

// Of the rows of one object; the paper's first.
std::vector<PaperRatio> ratios_of(std::span<const SummaryRow> rows) {
  std::vector<PaperRatio> list;
  for (const SummaryRow& row : rows) {
    if (is_baseline(row)) continue;
    const SummaryRow* baseline = find_baseline(rows, output_of(row.variant));
    if (baseline) list.push_back(ratio_of(row, *baseline));
  }
  if (!list.empty()) list.insert(list.begin(), paper_ratio(rows.front()));
  return list;
}

}  // namespace

std::vector<PaperRatio> paper_ratios(const std::vector<SummaryRow>& summary) {
  std::vector<PaperRatio> list;
  for (std::size_t first = 0, i = 0; i < summary.size(); ++i) {
    if (!ends_object(summary, i)) continue;
    if (summary[first].paper)
      for (PaperRatio& ratio : ratios_of(std::span(summary).subspan(first, i + 1 - first)))
        list.push_back(std::move(ratio));
    first = i + 1;
  }
  return list;
}

}  // namespace uniquadric
