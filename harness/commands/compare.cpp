#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <tuple>
#include <utility>

#include "core/base/apart.h"
#include "core/base/error.h"
#include "core/base/files.h"
#include "evaluation/comparison/score_comparison.h"
#include "harness/commands/commands.h"
#include "harness/commands/options.h"

namespace uniquadric {
namespace {

int exit_code_of(GateAnswer answer) {
  switch (answer) {
    case GateAnswer::pass:
      return 0;
    case GateAnswer::worse:
      return 1;
    case GateAnswer::undecided:
    case GateAnswer::incomplete:
      break;
  }
  return kBadInput;
}

// Of a results folder the commit of the program that filled it, else the path.
std::string source_of(const std::filesystem::path& path) {
  const std::filesystem::path file = path / "program.txt";
  if (!std::filesystem::is_regular_file(file)) return path.string();
  std::string text = read_text(file);
  text = text.substr(0, text.find('\n'));
  const std::size_t commit = text.find("commit ");
  return commit == std::string::npos ? path.string() : text.substr(commit);
}

// Commits tell the sides apart, paths where they do not.
std::pair<std::string, std::string> names_of_sides(const std::string& a, const std::string& b) {
  const std::string of_a = source_of(a), of_b = source_of(b);
  if (of_a != of_b || a == b) return {of_a, of_b};
  return of_a == a ? std::pair(a, b) : std::pair(of_a + " in " + a, of_b + " in " + b);
}

// Two variants go by one name, so that their runs are each other's pairs.
ScoreComparison compare(const std::string& a, const std::string& b, ScoreSelection of_a, ScoreSelection of_b,
                        const std::vector<std::string>& ignored, const GateOptions& options) {
  ScoreTable table_a = read_score_table(a, of_a), table_b = read_score_table(b, of_b);
  ignore_metrics(table_a, table_b, ignored);
  if (of_a.metrics.empty())
    for (ScoreTable* const table : {&table_a, &table_b}) leave_out_parts(*table);
  if (of_a.variant) {
    const std::string both =
        *of_a.variant == *of_b.variant ? *of_a.variant : *of_a.variant + " -> " + *of_b.variant;
    rename_variant(table_a, both);
    rename_variant(table_b, both);
  }
  ScoreComparison comparison = compare_scores(table_a, table_b, options);
  std::tie(comparison.a, comparison.b) = names_of_sides(a, b);
  if (of_a.variant) comparison.a += " (" + *of_a.variant + ")";
  if (of_b.variant) comparison.b += " (" + *of_b.variant + ")";
  return comparison;
}

}  // namespace

void add_compare(CLI::App& app, Common& common) {
  auto* sub = subcommand(
      app, "compare",
      "is B worse than A? over sequences and seeds; exit 0 no, 1 yes, 2 undecided or incomplete", common);
  static std::string a, b, variant_a, variant_b, markdown, junit;
  static std::vector<std::string> metrics, ignored;
  static bool as_json = false;
  static GateOptions options;
  sub->add_option("A", a, "results folder of bench, or scores.csv: what was")->required();
  sub->add_option("B", b, "the same: what is to be judged")->required();
  auto* of_a =
      sub->add_option("--variant-a", variant_a, "of A, with --variant-b; default: each with its like");
  auto* of_b = sub->add_option("--variant-b", variant_b, "of B; A and B may then be the same");
  of_a->needs(of_b);
  of_b->needs(of_a);
  sub->add_option("--metric", metrics, "this one alone; may stand several times")->allow_extra_args(false);
  sub->add_option("--ignore", ignored, "leave this metric out; may stand several times")
      ->allow_extra_args(false);
  sub->add_flag("--time", options.gate_time, "computing time and memory may fail, too");
  sub->add_flag("--json", as_json, "as JSON instead of a table");
  sub->add_option("--markdown", markdown, "file to write, for pasting into a pull request");
  sub->add_option("--junit", junit, "JUnit XML file to write: a test case for each metric");
  add_force(sub, common)->description("replace the files of --markdown and --junit");
  sub->callback([&common, of_a] {
    for (const std::string& file : {markdown, junit}) require_apart(file, {a, b});
    require_replaceable_file(markdown, common.force, {"Markdown of a comparison", "**"});
    require_replaceable_file(junit, common.force, {"XML file", "<?xml"});
    ScoreSelection of_a_side{std::nullopt, metrics}, of_b_side{std::nullopt, metrics};
    if (of_a->count() > 0) of_a_side.variant = variant_a, of_b_side.variant = variant_b;
    const ScoreComparison comparison = compare(a, b, of_a_side, of_b_side, ignored, options);
    if (!markdown.empty()) write_text(markdown, comparison_markdown(comparison));
    if (!junit.empty()) write_text(junit, comparison_junit(comparison));
    std::cout << (as_json ? comparison_json(comparison) : comparison_text(comparison));
    common.exit_code = exit_code_of(comparison.answer);
  });
}

}  // namespace uniquadric
