#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/version.h"
#include "evaluation/comparison/comparison_table.h"
#include "evaluation/results/markup.h"

namespace uniquadric {
namespace {

std::string markdown_table(const TableLines& lines, const std::string& sides) {
  std::string text;
  for (const auto& line : lines) {
    std::vector<std::string> cells;
    for (const std::string& cell : line) cells.push_back(markdown_cell(escaped(cell)));
    text += fmt::format("| {} |\n", fmt::join(cells, " | "));
    if (&line != &lines.front()) continue;
    for (const char side : sides) text += side == '<' ? "| --- " : "| ---: ";
    text += "|\n";
  }
  return text;
}

}  // namespace

std::string comparison_text(const ScoreComparison& comparison) {
  std::string text = fmt::format("A  {}\nB  {}\n   {}\n\n", comparison.a, comparison.b, extent(comparison));
  const TableLines lines = change_table(comparison, false);
  if (lines.size() > 1) text += aligned_columns(lines, sides_of(comparison)) + "\n";
  for (const GapList& list : gap_lists(comparison)) {
    text += list.title + ":\n";
    for (const std::string& line : list.lines) text += "  " + line + "\n";
    text += "\n";
  }
  return text + headline(comparison) + "\n";
}

std::string comparison_markdown(const ScoreComparison& comparison) {
  std::string text = fmt::format("**{}**\n\nA: `{}`, B: `{}`; {}.\n", headline(comparison), comparison.a,
                                 comparison.b, extent(comparison));
  const TableLines lines = change_table(comparison, false);
  if (lines.size() > 1) text += "\n" + markdown_table(lines, sides_of(comparison));
  for (const GapList& list : gap_lists(comparison)) {
    text += fmt::format("\n{}:\n", list.title);
    for (const std::string& line : list.lines) text += "- " + escaped(line) + "\n";
  }
  if (!comparison.metrics.empty())
    text += fmt::format("\n<details><summary>all metrics</summary>\n\n{}\n</details>\n",
                        markdown_table(change_table(comparison, true), sides_of(comparison)));
  return text + fmt::format("\nBy `uniquadric compare` ({}), rules in docs/compare.md.\n", kProgram);
}

}  // namespace uniquadric
